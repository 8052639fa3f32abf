// All fingers together, turned by hand: capsules, wires, the object's slices, forces.

const START = { x: -0.35, y: 0.55, z: 0 };

function makeSpace(element, scenes, most) {
  const illo = new Zdog.Illustration({ element, dragRotate: true, rotate: { ...START } });
  const middle = new Zdog.Anchor({ addTo: illo, translate: { x: -22, y: -46, z: 0 } });
  // The ghost is made first: of two parts equally far away the later one covers the earlier.
  const hands = scenes.map((scene, k) => ({ scene, look: k ? GHOST : BODY })).reverse()
    .map(({ scene, look }) => makeHand(middle, scene, look, most)).reverse();
  const draw = (shown) => {
    hands.forEach((hand, k) => hand.place(shown[k]));
    const width = element.clientWidth, height = element.clientHeight;
    if (illo.width !== width || illo.height !== height) {
      illo.setSize(width, height);
      element.style.width = element.style.height = "";
    }
    illo.zoom = Math.min(width / 230, height / 165);
    illo.updateRenderGraph();
  };
  return { draw, reset: () => illo.rotate.set(START), illo };
}

const shape = (parent, stroke, color) =>
  Object.assign(new Zdog.Shape({ addTo: parent, path: [{}, { x: 1 }], stroke, color, closed: false }), { own: color });
// A ghost stands behind a hand in the same pose.
function behind(shape) {
  shape.updateSortValue = function () {
    Zdog.Shape.prototype.updateSortValue.call(this);
    this.sortValue -= 4;
  };
}

const PALE = { under: "#d4d4d4", over: "#fafafa", wire: "#d4d4d4" };  // of a recording that is over

function makeHand(parent, scene, look, most) {
  const solid = look === BODY, root = new Zdog.Anchor({ addTo: parent });
  const fingers = scene.mounts.map((mount) => ({
    under: [0, 1, 2].map(() => shape(root, 2 * MM * mount[5] + (solid ? 1.6 : 0), solid ? INK : "rgba(213,94,0,.35)")),
    over: solid ? [0, 1, 2].map((k) => shape(root, 2 * MM * mount[5], k ? "#cfd8e3" : "#eef1f5")) : [],
    wire: shape(root, 1, "#789"),
    arrows: [0, 1].map(() => shape(root, 2.2, solid ? "#7a4a00" : "#d55e00")),
  }));
  const slices = (scene.slices ? scene.slices.planes : []).map((z) => ({
    z, ring: new Zdog.Shape({ addTo: root, path: [{}], stroke: 0.7, color: solid ? "rgba(0,90,60,.75)" : "rgba(213,94,0,.5)" }) }));
  const all = [...slices.map((each) => each.ring), ...fingers.flatMap((f) => [...f.under, ...f.over, f.wire, ...f.arrows])];
  if (!solid) all.forEach(behind);
  const hand = { fingers, slices, all, pose: "" };
  return { place: (state) => placeHand(hand, state, most) };
}

function placeHand(hand, state, most) {
  for (const each of hand.all) each.visible = state !== null;
  if (!state) return;
  const { scene, row } = state;
  hand.fingers.forEach((finger, f) => placeFinger(state, f, finger, most));
  const pose = [0, 1, 2].map((k) => scene.pose.at(row, k));
  if (pose.join() === hand.pose) return;  // most objects stand still
  hand.pose = pose.join();
  placeSlices(scene, pose, hand.slices);
}

function placeSlices(scene, [x, y, turn], slices) {
  const c = Math.cos(turn), s = Math.sin(turn);
  slices.forEach(({ z, ring }, k) => put(ring, scene.slices.points[k].filter((_, n) => n % 2 === 0).map(([u, v]) =>
    ({ x: MM * (c * u - s * v + x), y: -MM * (s * u + c * v + y), z: MM * z }))));
}

function placeFinger({ scene, row, over }, f, finger, most) {
  for (const kind of ["under", "over"]) for (const each of finger[kind]) each.color = over ? PALE[kind] : each.own;
  const [mountX, mountY, mountZ, facing] = scene.mounts[f];
  const lift = ([x, y], out = 0) => ({ x: MM * mountX + x, y: -(MM * mountY + facing * y), z: MM * mountZ + out });
  const ends = links(scene, row, f), wire = wireOf(f), stretch = scene.stretch.at(row, wire);
  for (let k = 0; k < 3; k++)
    for (const each of [finger.under[k], finger.over[k]]) if (each) put(each, [lift(ends[k]), lift(ends[k + 1])]);
  const look = pulled(scene.tension.at(row, wire), most), route = flexor(scene, ends);
  finger.wire.color = over ? PALE.wire : look.color;
  finger.wire.stroke = 0.6 * look.width;
  put(finger.wire, (stretch < 0 ? wavy(route, 1.8) : route).map((p) => lift(p)));
  finger.arrows.forEach((arrow, k) => {
    const touch = over ? null : contact(scene, row, 2 * f + k);
    arrow.visible = touch !== null;
    if (touch) put(arrow, arrowed(touch).map((p) => lift(p)));
  });
}

function put(shape, path) {
  shape.path = path;
  shape.updatePath();
}

// Shaft and head of an arrow as one line [mm].
function arrowed({ place: [x, y], force: [u, v] }) {
  const size = Math.hypot(u, v), length = 4 + ARROW * size, head = Math.min(4, 0.4 * length);
  const [a, b] = [u / size, v / size], tip = [x + length * a, y + length * b];
  const back = (side) => [tip[0] - head * (a - 0.6 * side * b), tip[1] - head * (b + 0.6 * side * a)];
  return [[x, y], tip, back(1), tip, back(-1)];
}

let ARROW = 0.4;  // mm per N, so that the largest force of the page stays in the picture
