"""The benchmark `learning`: whose code it runs."""

from benchmarks.learning import command


def test_another_checkout_runs_its_own_code(tmp_path):
    package = tmp_path / "hannes"
    package.mkdir()
    (package / "__init__.py").touch()
    said = tmp_path / "said"
    lines = ["import sys", f"open({str(said)!r}, 'w').write(sys.argv[1])"]
    (package / "__main__.py").write_text("\n".join(lines))
    assert command(tmp_path, "train") > 0.0
    assert said.read_text() == "train"
