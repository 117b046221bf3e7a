// Finds classes by their names and descriptions, as they are typed; works from files, without a server.
const field = document.getElementById("search"), found = document.getElementById("found");

function rank(entry, words) {
  const name = entry.name.toLowerCase(), text = `${name} ${entry.about.toLowerCase()}`;
  if (!words.every((word) => text.includes(word))) return 0;
  return name === words[0] ? 3 : name.startsWith(words[0]) ? 2 : 1;
}

field.addEventListener("input", () => {
  const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
  const hits = words.length ? ENTRIES.map((entry) => [rank(entry, words), entry]).filter(([r]) => r).sort((a, b) => b[0] - a[0]) : [];
  found.replaceChildren(...hits.slice(0, 12).map(([, entry]) => {
    const link = document.createElement("a"), about = document.createElement("small");
    link.href = entry.page;
    about.textContent = ` ${entry.about}`;
    link.append(entry.name, about);
    return link;
  }));
});
field.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && found.firstChild) location.href = found.firstChild.href;
  if (event.key === "Escape") { field.value = ""; found.replaceChildren(); }
});
