"""The paper's figures and tables beside ours, and the page that shows them."""
