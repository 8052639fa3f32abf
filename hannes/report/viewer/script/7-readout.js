// Numbers at the cursor: of the sample that is drawn, to the digits that distinguish channels.

// Columns of a scene: what was recorded and what was simulated, apart unless both are of one hand.
function columnsOf(scenes) {
  return scenes.flatMap((scene, k) => {
    const recorded = Object.keys(scene.recorded).length > 0, drawnBy = scene.drawnBy || "its own hand";
    if (scene.own && recorded) return [{ k, label: `${scene.name}, simulated`, tables: [scene.recorded, scene.simulated] }];
    const simulated = { k, label: recorded ? `simulated: ${drawnBy}` : scene.name, tables: [scene.simulated] };
    return recorded ? [{ k, label: `${scene.name}, recorded`, tables: [scene.recorded] }, simulated] : [simulated];
  });
}

function makeReadout(table, plots, scenes) {
  const columns = columnsOf(scenes), head = table.tHead.insertRow();
  for (const label of ["", ...columns.map((each) => each.label)])
    head.appendChild(Object.assign(document.createElement("th"), { textContent: label, title: label, scope: "col" }));
  const cells = plots.shown.map((channel) => {
    const row = table.tBodies[0].insertRow();
    row.appendChild(Object.assign(document.createElement("th"), { textContent: labelled(channel), scope: "row" }));
    return columns.map(() => row.insertCell());
  });
  // rows: the row of each scene, null where it is over
  const write = (rows) => plots.shown.forEach(({ name }, n) => columns.forEach(({ k, tables }, c) => {
    const values = tables.map((each) => each[name]).find((each) => each), cell = cells[n][c];
    const text = values && rows[k] !== null ? String(Number(values[rows[k]].toPrecision(6))) : "–";
    if (cell.textContent !== text) cell.textContent = text;
  }));
  const show = (visible) => columns.forEach(({ k }, c) => [head.cells[c + 1], ...cells.map((row) => row[c])]
    .forEach((cell) => (cell.hidden = !visible[k])));
  return { write, show };
}
