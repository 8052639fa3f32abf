// Each finger in its own plane, to scale: capsules, the object's section, wire and forces.

function drawPlanes(canvas, states, names, most) {
  const { pen, width, height } = fitted(canvas), cell = width / 5;
  const scale = Math.min(cell / 152, (height - 38) / 96);
  for (let f = 0; f < 5; f++) {
    pen.save();
    pen.beginPath();
    pen.rect(f * cell, 0, cell, height);
    pen.clip();
    caption(pen, states[0], f, names[f], f * cell + 6, height - 6);
    pen.translate(f * cell + cell / 2 - 26 * scale, 18 + (height - 38 - 96 * scale) / 2 + 10 * scale);
    pen.scale(scale, -scale);
    if (states[1]) drawFinger(pen, states[1], f, GHOST, scale, most);
    drawFinger(pen, states[0], f, BODY, scale, most);
    pen.restore();
    if (f) line(pen, f * cell, height);
  }
}

function line(pen, x, height) {
  traced(pen, [[x, 0], [x, height]]);
  pen.strokeStyle = "#ccc";
  pen.lineWidth = 1;
  pen.stroke();
}

function caption(pen, { scene, row, over }, f, name, x, y) {
  const force = over ? 0 : [0, 1].map((k) => contact(scene, row, 2 * f + k)).reduce(
    (sum, each) => sum + (each ? Math.hypot(...each.force) : 0), 0);
  pen.fillStyle = INK;
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  pen.fillText(force > 0.05 ? `${name} ${force.toFixed(1)} N` : name, x, y);
}

function drawFinger(pen, { scene, row, over }, f, look, scale, most) {
  pen.globalAlpha = over ? FADED : 1;
  const ends = links(scene, row, f), radius = MM * scene.mounts[f][5];
  if (scene.sections) {
    traced(pen, section(scene, row, f), true);
    outline(pen, look === BODY ? "#e3f1ea" : "transparent", look === BODY ? "#00664b" : look.edge, look.dash, scale);
  }
  for (let k = 0; k < 3; k++) {
    capsule(pen, ends[k], ends[k + 1], radius);
    outline(pen, k ? look.fill : look === BODY ? "#eef1f5" : look.fill, look.edge, look.dash, scale);
  }
  const wire = wireOf(f), route = flexor(scene, ends), pull = pulled(scene.tension.at(row, wire), most);
  traced(pen, scene.stretch.at(row, wire) < 0 ? wavy(route, 1.6) : route);
  pen.setLineDash(look.dash.map((each) => each / scale));
  pen.strokeStyle = look === BODY ? pull.color : look.edge;
  pen.lineWidth = pull.width / scale;
  pen.stroke();
  pen.setLineDash([]);
  for (let k = 0; k < 2 && !over; k++) {
    const touch = contact(scene, row, 2 * f + k);
    if (!touch) continue;
    traced(pen, arrowed(touch));
    pen.strokeStyle = look === BODY ? "#7a4a00" : look.edge;
    pen.lineWidth = 2 / scale;
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

function outline(pen, fill, edge, dash, scale) {
  pen.fillStyle = fill;
  pen.fill();
  pen.setLineDash(dash.map((each) => each / scale));
  pen.strokeStyle = edge;
  pen.lineWidth = 1.2 / scale;
  pen.stroke();
  pen.setLineDash([]);
}

function capsule(pen, a, b, radius) {
  const angle = Math.atan2(b[1] - a[1], b[0] - a[0]), quarter = Math.PI / 2;
  pen.beginPath();
  pen.arc(a[0], a[1], radius, angle + quarter, angle - quarter);
  pen.arc(b[0], b[1], radius, angle - quarter, angle + quarter);
  pen.closePath();
}
