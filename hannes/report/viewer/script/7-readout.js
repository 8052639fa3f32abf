// Numbers at the cursor: of the sample that is drawn, to the digits that tell channels apart.

function makeReadout(table, plots, scenes) {
  const columns = scenes.flatMap((scene, k) => ["recorded", "simulated"]
    .filter((kind) => Object.keys(scene[kind]).length)
    .map((kind) => ({ k, kind, label: `${scene.name}${kind === "simulated" && Object.keys(scene.recorded).length ? ", simulated" : ""}` })));
  const head = table.tHead.insertRow();
  for (const label of ["", ...columns.map((each) => each.label)])
    head.appendChild(Object.assign(document.createElement("th"), { textContent: label, scope: "col" }));
  const cells = plots.shown.map((channel) => {
    const row = table.tBodies[0].insertRow();
    row.appendChild(Object.assign(document.createElement("th"), { textContent: told(channel), scope: "row" }));
    return columns.map(() => row.insertCell());
  });
  const write = (rows) => plots.shown.forEach(({ name }, n) => columns.forEach(({ k, kind }, c) => {
    const values = scenes[k][kind][name], cell = cells[n][c];
    const text = values && rows[k] !== null ? String(Number(values[rows[k]].toPrecision(6))) : "–";
    if (cell.textContent !== text) cell.textContent = text;
  }));
  const show = (visible) => columns.forEach(({ k }, c) => [head.cells[c + 1], ...cells.map((row) => row[c])]
    .forEach((cell) => (cell.hidden = !visible[k])));
  return { write, show };
}
