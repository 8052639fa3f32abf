// What all three pictures share: links, wires, arrows, colours.

const MM = 1000, INK = "#1a1a1a";
const BODY = { fill: "#cfd8e3", edge: INK, dash: [] };
const GHOST = { fill: "rgba(213,94,0,.10)", edge: "#b34e00", dash: [4, 3] };
const WAVES = 26;
const FADED = 0.22;  // share of ink that is left of a recording that is over

// Ends of a finger's three phalanges in its plane [mm].
function links(scene, row, f) {
  const at = (k) => MM * scene.points.at(row, 4 * f + k);
  const first = MM * scene.mounts[f][4];
  return [[-first, 0], [0, 0], [at(0), at(1)], [at(2), at(3)]];
}

// Flexor wire along a finger: on the closing side of each link, at the joints' moment arms [mm].
function flexor(scene, ends) {
  const [near, far] = scene.arms.map((each) => MM * each);
  const below = (a, b, place, by) => {
    const x = b[0] - a[0], y = b[1] - a[1], length = Math.hypot(x, y);
    return [place[0] + (by * y) / length, place[1] - (by * x) / length];
  };
  const end = [0.4 * ends[2][0] + 0.6 * ends[3][0], 0.4 * ends[2][1] + 0.6 * ends[3][1]];
  return [below(ends[0], ends[1], ends[0], near), below(ends[0], ends[1], ends[1], near),
    below(ends[1], ends[2], ends[1], near), below(ends[1], ends[2], ends[2], Math.max(far, 8)),
    below(ends[2], ends[3], end, 8)];
}

// Which of the wires moves finger f: leader 0, followers 1 and 2.
const wireOf = (f) => (f === 4 ? 0 : f < 2 ? 1 : 2);

// The same route, in waves where the wire is slack.
function wavy(route, height) {
  const lengths = route.slice(1).map((p, k) => Math.hypot(p[0] - route[k][0], p[1] - route[k][1]));
  const whole = lengths.reduce((a, b) => a + b, 0), points = [];
  for (let k = 0, part = 0, gone = 0; k <= 4 * WAVES; k++) {
    const place = (whole * k) / (4 * WAVES);
    while (part < lengths.length - 1 && place > gone + lengths[part]) gone += lengths[part++];
    const share = lengths[part] ? (place - gone) / lengths[part] : 0;
    const [a, b] = [route[part], route[part + 1]];
    const x = (b[0] - a[0]) / (lengths[part] || 1), y = (b[1] - a[1]) / (lengths[part] || 1);
    const off = height * Math.sin((k * Math.PI) / 2) * Math.min(1, (4 * WAVES - k) / 4, k / 4);
    points.push([a[0] + share * (b[0] - a[0]) - off * y, a[1] + share * (b[1] - a[1]) + off * x]);
  }
  return points;
}

// How a wire looks: darker and thicker the harder it is pulled.
function pulled(tension, most) {
  const share = Math.min(1, Math.max(0, tension / most));
  const mix = (from, to) => Math.round(from + (to - from) * share);
  return { color: `rgb(${mix(120, 120)},${mix(150, 0)},${mix(180, 25)})`, width: 1.2 + 3.2 * share };
}

// Object's section in finger f's plane [mm].
function section(scene, row, f) {
  const [x, y, turn] = [0, 1, 2].map((k) => scene.pose.at(row, k));
  const [mountX, mountY, , facing] = scene.mounts[f], c = Math.cos(turn), s = Math.sin(turn);
  return scene.sections.points[f].map(([u, v]) => [
    MM * (c * u - s * v + x - mountX), MM * facing * (s * u + c * v + y - mountY)]);
}

// Contact of a phalanx: where, and the force on the object there [mm, N]; null where there is none.
function contact(scene, row, phalanx) {
  const at = (table, k) => table.at(row, 2 * phalanx + k);
  const force = [-at(scene.pushes, 0), -at(scene.pushes, 1)];
  if (Math.hypot(...force) < 0.05) return null;
  return { place: [MM * at(scene.contacts, 0), MM * at(scene.contacts, 1)], force };
}

function fitted(canvas) {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

function traced(pen, points, closed) {
  pen.beginPath();
  points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  if (closed) pen.closePath();
}
