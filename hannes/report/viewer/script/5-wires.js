// Motor, carts and wires, as in the schematic; carts where they are, slack wires in waves.

const WIRES = ["leader", "follower_a", "follower_b"];

function drawWires(canvas, states, layout, names, most) {
  const { pen, width, height } = fitted(canvas);
  const scale = Math.min(width / 640, (height - 20) / 445), wide = Math.max(640, width / scale);
  pen.translate(((wide - 640) * scale) / 2, 8 - 20 * scale);
  pen.scale(scale, scale);
  const size = Math.max(12, 11.5 / scale);
  if (states[1]) drawDrive(pen, states[1], layout, GHOST, most);
  drawDrive(pen, states[0], layout, BODY, most);
  labels(pen, states[0], layout, names, size);
}

function drawDrive(pen, { scene, row, over }, layout, look, most) {
  pen.globalAlpha = over ? FADED : 1;
  const gone = [0, 1].map((k) => layout.travel * scene.carts.at(row, k)), solid = look === BODY;
  Object.values(layout.carts).forEach(([x, y], k) => {
    traced(pen, [[x - 56 - gone[k], y - 30], [x + 56 - gone[k], y - 30], [x + 56 - gone[k], y + 34], [x - 56 - gone[k], y + 34]], true);
    outline(pen, solid ? "rgba(225,231,238,.75)" : "transparent", look.edge, look.dash, 1);
    for (const side of [-32, 32]) wheel(pen, x + side - gone[k], y, layout.wheel - 2, look);
    if (solid) rail(pen, x, y + 40);
  });
  const [x, y] = layout.motor, angle = scene.motor.at(row, 0);
  wheel(pen, x, y, layout.wheel, look);
  traced(pen, [[x, y], [x + layout.wheel * Math.cos(angle), y + layout.wheel * Math.sin(angle)]]);
  pen.lineWidth = 2;
  pen.stroke();
  WIRES.forEach((name, k) => {
    const route = layout.wires[name].map(([px, py, cart]) => [cart ? px - gone[cart === "a" ? 0 : 1] : px, py]);
    const pull = pulled(scene.tension.at(row, k), most);
    traced(pen, scene.stretch.at(row, k) < 0 ? wavy(route, 7) : route);
    pen.setLineDash(look.dash);
    pen.strokeStyle = solid ? pull.color : look.edge;
    pen.lineWidth = 1.3 * pull.width;
    pen.stroke();
    pen.setLineDash([]);
  });
  pen.globalAlpha = 1;
}

function wheel(pen, x, y, radius, look) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  outline(pen, look === BODY ? "rgba(255,255,255,.8)" : "transparent", look.edge, look.dash, 1);
}

function rail(pen, x, y) {
  traced(pen, [[x - 130, y], [x + 80, y]]);
  pen.strokeStyle = "#888";
  pen.lineWidth = 1.5;
  pen.stroke();
}

function labels(pen, { scene, row, over }, layout, names, size) {
  pen.font = `${size}px system-ui, 'DejaVu Sans', sans-serif`;
  pen.fillStyle = INK;
  const wire = (k, name) => {
    const slack = -MM * scene.stretch.at(row, k);
    if (over) return `${name} –`;
    return slack > 0 ? `${name} slack ${slack.toFixed(2)} mm` : `${name} ${scene.tension.at(row, k).toFixed(1)} N`;
  };
  pen.fillText("motor", layout.motor[0] - 20, layout.motor[1] + 45);
  pen.fillText(wire(0, "leader"), 150, layout.carts.a[1] + 100);
  Object.entries(layout.carts).forEach(([name, [x, y]], k) => {
    const gone = over ? "–" : `${(MM * scene.carts.at(row, k)).toFixed(2)} mm`;
    pen.textAlign = "right";
    pen.fillText(`cart ${name.toUpperCase()} ${gone}`, x + 30, y + 44 + size);
    pen.textAlign = "left";
    pen.fillText(wire(1 + k, "follower"), x + 74, y + 6);
  });
  names.forEach((name) => pen.fillText(name, layout.fingers[name][0] + 10, layout.fingers[name][1] + 24));
}
