"""One page on this machine alone: its address has a token, its Host and Origin are checked.

The server is that of the library `websockets` (extra `panel`). It listens on 127.0.0.1, so that no
other machine reaches it. Other pages of the same browser could: a page of another origin is refused
by its Origin, a name that was made to lead here by its Host, and both by the token.
"""

import hmac
import json
import queue
import secrets
import threading
import time
from collections.abc import Callable
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import parse_qs, urlsplit

from hannes.bench.port import HOST, listening
from hannes.core.errors import BadInput
from hannes.core.io.json_text import parsed

if TYPE_CHECKING:
    from websockets.http11 import Request, Response
    from websockets.sync.server import ServerConnection

FRAME = 0.04  # s between two pictures
LONGEST = 4096  # bytes of a message of the page
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "connect-src ws://{host}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)


class PanelServer:
    """Serves `page` and speaks with it: `asked` holds its messages, `state` says what it is shown.

    Raises BadInput where the library is missing or the port cannot be had. `port` 0: any.
    """

    def __init__(self, page: str, state: Callable[[], dict[str, Any]], port: int = 0) -> None:
        try:
            from websockets.sync.server import serve
            from websockets.typing import Origin
        except ImportError:
            raise BadInput(
                "the panel needs the package websockets: pip install 'hannes[panel]'"
            ) from None
        own = listening(port)
        self.host = f"{HOST}:{own.getsockname()[1]}"
        self._own = f"http://{self.host}"  # the page's origin
        self.asked: queue.Queue[dict[str, Any]] = queue.Queue()
        self._page, self._state, self._token = page, state, secrets.token_urlsafe(24)
        self._alone = threading.Lock()
        self._server = serve(
            self._speak,
            sock=own,
            process_request=self._judge,
            origins=[Origin(self._own)],
            max_size=LONGEST,
            compression=None,
            ping_interval=None,  # the page's own beats are quicker
        )
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    @property
    def address(self) -> str:
        """What is opened in the browser, the token in it."""
        return f"{self._own}/?token={self._token}"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._thread.join()

    def _judge(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Refuse, serve the page, or go on to the conversation (None)."""
        split = urlsplit(request.path)
        token = parse_qs(split.query).get("token", [""])[0]
        if request.headers.get_all("Host") != [self.host]:
            return _refusal(HTTPStatus.MISDIRECTED_REQUEST, f"expected the address {self.host}")
        if any(each != self._own for each in request.headers.get_all("Origin")):
            return _refusal(HTTPStatus.FORBIDDEN, "a request of another page is refused")
        if not hmac.compare_digest(token.encode(), self._token.encode()):
            return _refusal(
                HTTPStatus.FORBIDDEN, "wrong or no token: open the address that the command printed"
            )
        if split.path == "/ws":
            return None
        if split.path != "/":
            return _refusal(HTTPStatus.NOT_FOUND, "there is one page, and this is not its address")
        return _response(HTTPStatus.OK, "text/html", self._page, POLICY.format(host=self.host))

    def _speak(self, connection: "ServerConnection") -> None:
        """A conversation with the page; its end counts as a stop."""
        if not self._alone.acquire(blocking=False):
            connection.close(1013, "another page has the hand")
            return
        try:
            self._exchange(connection)
        finally:
            self.asked.put({"do": "stop"})
            self._alone.release()

    def _exchange(self, connection: "ServerConnection") -> None:
        from websockets.exceptions import ConnectionClosed

        due = 0.0
        try:
            while True:
                if (now := time.monotonic()) >= due:
                    connection.send(json.dumps(self._state(), allow_nan=False))
                    due = now + FRAME
                try:
                    message = connection.recv(timeout=max(due - time.monotonic(), 0.001))
                except TimeoutError:
                    continue
                self._take(message)
        except ConnectionClosed:
            pass

    def _take(self, message: str | bytes) -> None:
        try:
            asked = parsed(message)
        except ValueError:
            return
        if isinstance(asked, dict):
            self.asked.put(asked)


def _refusal(status: HTTPStatus, why: str) -> "Response":
    return _response(status, "text/plain", f"{why}\n", "default-src 'none'")


def _response(status: HTTPStatus, kind: str, text: str, policy: str) -> "Response":
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    body = text.encode()
    headers = {
        "Content-Type": f"{kind}; charset=utf-8",
        "Content-Length": str(len(body)),
        "Content-Security-Policy": policy,
        "Cache-Control": "no-store",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "Connection": "close",
    }
    return Response(status.value, status.phrase, Headers(headers), body)
