// Numbers at the cursor: of the sample that is drawn, to the digits that distinguish channels.

const overlap = (scene) => Object.keys(scene.simulated).some((name) => name in scene.recorded);

// One column a scene; two where the same channels were recorded and simulated.
function columnsOf(scenes) {
  return scenes.flatMap((scene, k) => overlap(scene)
    ? [{ k, label: `${scene.name}, recorded`, tables: [scene.recorded] }, { k, label: "simulated", tables: [scene.simulated] }]
    : [{ k, label: scene.name, tables: [scene.recorded, scene.simulated] }]);
}

function makeReadout(table, plots, scenes) {
  const columns = columnsOf(scenes), head = table.tHead.insertRow();
  for (const label of ["", ...columns.map((each) => each.label)])
    head.appendChild(Object.assign(document.createElement("th"), { textContent: label, scope: "col" }));
  const cells = plots.shown.map((channel) => {
    const row = table.tBodies[0].insertRow();
    row.appendChild(Object.assign(document.createElement("th"), { textContent: labelled(channel), scope: "row" }));
    return columns.map(() => row.insertCell());
  });
  const write = (rows) => plots.shown.forEach(({ name }, n) => columns.forEach(({ k, tables }, c) => {
    const values = tables.map((each) => each[name]).find((each) => each), cell = cells[n][c];
    const text = values ? String(Number(values[rows[k]].toPrecision(6))) : "–";
    if (cell.textContent !== text) cell.textContent = text;
  }));
  const show = (visible) => columns.forEach(({ k }, c) => [head.cells[c + 1], ...cells.map((row) => row[c])]
    .forEach((cell) => (cell.hidden = !visible[k])));
  return { write, show };
}
