"""The API reference is built from the docstrings without a warning and has every public name."""

import re

import pytest

import ftcfa

pdoc = pytest.importorskip("pdoc", reason="the extra 'dev' has it")


@pytest.mark.filterwarnings("error")
def test_the_reference_has_every_public_name(tmp_path):
    pdoc.render.configure(docformat="google", show_source=False)
    pdoc.pdoc("ftcfa", output_directory=tmp_path)
    page = (tmp_path / "ftcfa.html").read_text()
    shown = re.findall(r'<section id="([^".]+)">', page)
    assert sorted(shown) == sorted(ftcfa.__all__)
    documented = page[page.index('<section id="FTCF">') :]
    assert "Finite-time command-filtered adaptive" in documented[: documented.index("</section>")]
