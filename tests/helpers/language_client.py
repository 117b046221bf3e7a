"""A client of the language server that speaks the protocol itself, as an editor does: JSON-RPC over pipes."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any


class Client:
    """A server that was started and told of a folder; requests wait for their answers, notifications are kept, and in the end
    what it wrote to its standard error."""

    written = ""

    def __init__(self, folder: Path, patience: float = 30.0) -> None:
        self.process = subprocess.Popen([sys.executable, "-m", "lagrangia", "server", "--stdio"], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder)
        self.folder, self.patience, self.number = folder, patience, 0
        self.told: list[dict[str, Any]] = []
        answer = self.ask("initialize", processId=None, rootUri=folder.as_uri(), capabilities={},
                          workspaceFolders=[{"uri": folder.as_uri(), "name": folder.name}])
        self.capabilities = answer["capabilities"]
        self.tell("initialized")

    def close(self) -> int:
        """Ends the server as the protocol says; its exit code."""
        self.ask("shutdown")
        self.tell("exit")
        code = self.process.wait(10)
        self.written = self.process.communicate()[1].decode()
        return code

    def tell(self, method: str, **params: Any) -> None:
        """A notification."""
        self._send({"jsonrpc": "2.0", "method": method, "params": params})

    def ask(self, method: str, **params: Any) -> Any:
        """The result of a request; raises ValueError with what the server refuses it for."""
        self.number += 1
        request = {"jsonrpc": "2.0", "id": self.number, "method": method}
        self._send(request | ({"params": params} if params else {}))
        while (message := self._read()).get("id") != self.number or "method" in message:
            self.told.append(message)
        if "error" in message:
            raise ValueError(message["error"]["message"])
        return message["result"]

    def open(self, name: str, text: str) -> tuple[str, list[dict[str, Any]]]:
        """A text that is opened: its address, and what is wrong with it."""
        uri = (self.folder / name).as_uri()
        self.tell("textDocument/didOpen", textDocument={"uri": uri, "languageId": "lag", "version": 1, "text": text})
        return uri, self.diagnostics(uri)

    def change(self, uri: str, text: str, version: int) -> tuple[list[dict[str, Any]], float]:
        """What is wrong with another text, and how long it took to be told."""
        start = time.perf_counter()
        self.tell("textDocument/didChange", textDocument={"uri": uri, "version": version}, contentChanges=[{"text": text}])
        return self.diagnostics(uri), time.perf_counter() - start

    def processor_seconds(self) -> float:
        """That the server has taken (Linux)."""
        words = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    def diagnostics(self, uri: str) -> list[dict[str, Any]]:
        """The next ones of this text."""
        while True:
            message = self.told.pop(0) if self.told else self._read()
            if message.get("method") == "textDocument/publishDiagnostics" and message["params"]["uri"] == uri:
                return message["params"]["diagnostics"]

    def at(self, what: str, uri: str, text: str, mark: str, shift: int = 0, **more: Any) -> Any:
        """A request about the place where `mark` begins in the text."""
        before = text[: text.index(mark) + shift]
        place = {"line": before.count("\n"), "character": len(before.rpartition("\n")[2])}
        return self.ask(f"textDocument/{what}", textDocument={"uri": uri}, position=place, **more)

    def _send(self, message: dict[str, Any]) -> None:
        body = json.dumps(message).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def _read(self) -> dict[str, Any]:
        size = 0
        while (line := self.process.stdout.readline()) not in (b"\r\n", b""):
            if line.lower().startswith(b"content-length:"):
                size = int(line.split(b":")[1])
        assert size, self.process.stderr.read().decode()
        return json.loads(self.process.stdout.read(size))
