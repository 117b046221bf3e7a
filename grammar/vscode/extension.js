// Starts `lag server` and lets it answer for all texts of the language.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const [command, ...args] = workspace.getConfiguration("lagrangia").get("command");
  client = new LanguageClient("lagrangia", "Lagrangia", { command, args }, { documentSelector: [{ language: "lag" }] });
  return client.start();
};

exports.deactivate = () => client?.stop();
