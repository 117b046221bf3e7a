"""The text of `lag help editor`."""

EDITOR = """\
lag format FILE|FOLDER ... [--check | --diff]     (- for standard input to output)
One layout for all texts: two spaces an indent, sections below their class, one statement a line, a + b and a*b, [i+1] and 1:n-1,
lines of at most 130 characters. Words and comments stay what they are, in their order. Where the author ended a line at a place
that suits (behind a comma, before an operator, a description, then, else, for) it ends there; words that stand below each other
with intent (names, =, descriptions, comments) still do. A file with errors of syntax stays as it is, exit code 2; --check writes
nothing, exit code 1 where a file would change.

lag lint FILE ...
What `lag check` warns of, and style; exit code 1 where something is found. --allow L0803, or annotation(allow = "L0803") in
a class:
L0801 nothing uses it   L0802 it hides something   L0803 a quantity in a formula without a name   L0804 a name against the custom
L0805 Real(unit = ...) where a type says the same   L0806 not laid out as lag format does it

lag new NAME
A folder with a part, a scene that uses it, a test, and the line for CI: lag format --check . && lag lint *.lag && lag test

lag test [FILE|FOLDER ...] [--tolerance 1e-6] [--update]
Runs models whose names begin with Test, of the folder tests by default; of a named file that has none, the last one.
Where MODEL.csv stands beside it, the motion is compared at its times: each column may differ by that share of its largest value.
--update stores what the runs give. Exit code 1 where a run or a comparison fails, 2 where a text is wrong.

lag doc [FILE|FOLDER ...] [-o FOLDER]
Pages of the library with its packages, of your files, and of all files of a folder that is a package: text, a picture of each
component (alone, its ports held or moved by what is not drawn), parameters with units and defaults, ports, energies and equations
as they are written, who uses it, source. Opens from files.

lag server
The language server, over standard input and output: pip install 'lagrangia[editor]'. Errors of syntax, names and units come while
you type, those of all other phases when the text is saved. Neovim:

    vim.lsp.start({name = "lag", cmd = {"lag", "server"}, root_dir = vim.fs.dirname(vim.api.nvim_buf_get_name(0))})

VS Code: the folder grammar/vscode; in a copy of it, npm install && npx @vscode/vsce package --allow-missing-repository
Emacs (eglot):  (add-to-list 'eglot-server-programs '(lag-mode . ("lag" "server")))
Helix:          [language-server.lag] command = "lag", args = ["server"]
Sphinx, MkDocs and minted colour .lag by the Pygments lexer that comes with this package (```lag, or language lagrangia).
"""
