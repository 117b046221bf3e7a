"""The text of `lag help editor`."""

EDITOR = """\
lag format FILE|FOLDER ... [--check | --diff]     (- for standard input to output)
One layout for all texts: two spaces an indent, sections below their class, one statement a line, a + b and a*b, [i+1] and 1:n-1,
lines of at most 130 characters. Words and comments stay what they are, in their order. Where the author ended a line at a place
that suits (behind a comma, before an operator, a description, then, else, for) it ends there; words that stand below each other
with intent (names, =, descriptions, comments) still do. A file with errors of syntax stays as it is, exit code 2; --check writes
nothing, exit code 1 where a file would change.

lag server
The language server, over standard input and output: pip install 'lagrangia[editor]'. Errors of syntax, names and units come while
you type, those of all other phases when the text is saved. Neovim:

    vim.lsp.start({name = "lag", cmd = {"lag", "server"}, root_dir = vim.fs.dirname(vim.api.nvim_buf_get_name(0))})

Emacs (eglot):  (add-to-list 'eglot-server-programs '(lag-mode . ("lag" "server")))
Helix:          [language-server.lag] command = "lag", args = ["server"]
"""
