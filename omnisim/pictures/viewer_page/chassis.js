// The chassis: a box between the inner faces of the wheels, with the axles, and a mark where front is. It leaves room for
// what carries wheels.

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  Color,
  ConvexGeometry,
  EdgesGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Vector3,
  mergeGeometries,
} from "vendor";
import { Carriers, axleGeometry, innerFace, insideGap, springTop } from "omnisim/carriers";

const COLOURS = { box: 0x3f6f9f, mark: 0xf2f4f6, axle: 0x8b949c, edge: 0x1d3347 };
const BEHIND_EDGES = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
const FROM_FLOOR = [0.6, 1.3]; // lower and upper face, in wheel radii
const LEVEL = 1.003; // of the mark, just above the upper face
const NOSE = 0.4; // half its width at a pivot, in wheel radii
const [POST, PLATE] = [0.12, 0.2]; // thick; half as wide; in wheel radii

export function chassisOf(wheels) {
  const centre = new Vector3();
  for (const { mount } of wheels) centre.add(new Vector3().setFromMatrixPosition(mount).divideScalar(wheels.length));
  const radius = Math.max(...wheels.map(({ type }) => type.radius));
  const [low, high] = FROM_FLOOR.map((radii) => radii * radius);
  const points = wheels.flatMap((wheel) => cornersAt(wheel, centre));
  for (const [x, y] of [
    [-0.3, -0.3],
    [-0.3, 0.3],
    [0.3, -0.3],
    [0.3, 0.3],
  ])
    // some box for wheels in one place
    points.push(new Vector3(centre.x + x * radius, centre.y + y * radius, 0));
  const box = new ConvexGeometry(points.flatMap(({ x, y }) => [new Vector3(x, y, low), new Vector3(x, y, high)]));
  const edges = new LineSegments(new EdgesGeometry(box, 20), new LineBasicMaterial({ color: COLOURS.edge }));
  const sprung = wheels.filter((wheel) => wheel.sprung);
  const rocking = wheels.filter(({ wheel }) => wheel.rocker);
  const fixed = wheels.filter((wheel) => !wheel.sprung && !wheel.wheel.rocker);
  const front = centre.x + 0.8 * (Math.max(...points.map(({ x }) => x)) - centre.x);
  const parts = [
    painted(box, COLOURS.box),
    painted(markGeometry(front, centre.y, LEVEL * high, radius), COLOURS.mark),
    ...fixed.map((wheel) => painted(axleGeometry(wheel, centre).toNonIndexed(), COLOURS.axle)),
    ...sprung.map((wheel) => painted(towerGeometry(wheel, centre).toNonIndexed(), COLOURS.box)),
    ...rocking.map((wheel) => painted(postGeometry(wheel, centre, (low + high) / 2).toNonIndexed(), COLOURS.box)),
  ];
  const material = new MeshLambertMaterial({ vertexColors: true, ...BEHIND_EDGES });
  const carriers = new Carriers(wheels, centre);
  const group = new Group().add(new Mesh(mergeGeometries(parts), material), edges, carriers.group);
  group.matrixAutoUpdate = false;
  return { group, carriers };
}

// Towards a wheel it ends where the wheel begins; towards one on a rocker across it, at the pivot.
function cornersAt(wheel, centre) {
  const { type, mount } = wheel;
  const { axis, point } = wheel.wheel.rocker ?? { axis: [0] };
  if (axis[0]) return [-NOSE, NOSE].map((y) => new Vector3(point[0], point[1] + y * type.radius, 0));
  const inner = innerFace(wheel, centre);
  return [-0.7, 0.7].map((x) => new Vector3(x * type.radius, inner, 0).applyMatrix4(mount));
}

// What holds a spring at its upper end: a post on the chassis, and a plate over the spring.
function towerGeometry(wheel, centre) {
  const { radius } = wheel.type;
  const [face, top, thick] = [innerFace(wheel, centre), springTop(wheel), POST * radius];
  const inward = Math.sign(face);
  const [inner, outer] = [face + inward * thick, insideGap(wheel, centre) - inward * PLATE * radius];
  const post = new BoxGeometry(2 * PLATE * radius, thick, top).translate(0, face + (inward * thick) / 2, top / 2);
  const plate = new BoxGeometry(2 * PLATE * radius, Math.abs(inner - outer), thick / 2);
  return mergeGeometries([post, plate.translate(0, (inner + outer) / 2, top)]).applyMatrix4(wheel.mount);
}

// What holds the pin of a rocker: a post from the middle of the chassis, for pivots above or below it.
function postGeometry(wheel, centre, middle) {
  const { axis, point } = wheel.wheel.rocker;
  const wide = 2 * POST * wheel.type.radius;
  const inner = new Vector3(0, innerFace(wheel, centre), 0).applyMatrix4(wheel.mount).y;
  const y = axis[0] ? point[1] : inner - Math.sign(inner - centre.y) * POST * wheel.type.radius;
  const post = new BoxGeometry(wide, wide, Math.abs(point[2] - middle) + wide);
  return post.translate(point[0], y, (point[2] + middle) / 2);
}

// A triangle that points forward.
function markGeometry(x, y, z, radius) {
  const corners = [
    new Vector3(x, y, z),
    ...[0.45, -0.45].map((side) => new Vector3(x - 0.9 * radius, y + side * radius, z)),
  ];
  const geometry = new BufferGeometry().setFromPoints(corners);
  geometry.computeVertexNormals();
  return geometry;
}

// Position, normal and colour at each corner, so that all parts are drawn at once.
function painted(geometry, paint) {
  const colours = new Float32Array(geometry.attributes.position.array.length);
  const colour = new Color(paint).toArray();
  for (let i = 0; i < colours.length; i += 3) colours.set(colour, i);
  geometry.deleteAttribute("uv");
  return geometry.setAttribute("color", new BufferAttribute(colours, 3));
}
