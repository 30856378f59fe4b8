// The chassis: a box between the inner faces of the wheels, with the axles, and a mark where front is.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  ConvexGeometry,
  CylinderGeometry,
  EdgesGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Vector3,
  mergeGeometries,
} from "vendor";
import { halfWidth } from "omnisim/wheels";

const COLOURS = { box: 0x3f6f9f, mark: 0xf2f4f6, axle: 0x8b949c, edge: 0x1d3347 };
const BEHIND_EDGES = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
const FROM_FLOOR = [0.6, 1.3]; // lower and upper face, in wheel radii
const LEVEL = 1.003; // of the mark, just above the upper face

export function chassisOf(wheels) {
  const centre = new Vector3();
  for (const { mount } of wheels) centre.add(new Vector3().setFromMatrixPosition(mount).divideScalar(wheels.length));
  const radius = Math.max(...wheels.map(({ type }) => type.radius));
  const [low, high] = FROM_FLOOR.map((radii) => radii * radius);
  const points = wheels.flatMap((wheel) => innerCorners(wheel, centre));
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
  const front = centre.x + 0.8 * (Math.max(...points.map(({ x }) => x)) - centre.x);
  const parts = [
    painted(box, COLOURS.box),
    painted(markGeometry(front, centre.y, LEVEL * high, radius), COLOURS.mark),
    ...wheels.map((wheel) => painted(axleGeometry(wheel, centre).toNonIndexed(), COLOURS.axle)),
  ];
  const material = new MeshLambertMaterial({ vertexColors: true, ...BEHIND_EDGES });
  const group = new Group().add(new Mesh(mergeGeometries(parts), material), edges);
  group.matrixAutoUpdate = false;
  return group;
}

// Where the chassis begins along the axle of a wheel, towards the centre.
function innerFace({ wheel, type, mount }, centre) {
  const inward = centre.clone().applyMatrix4(mount.clone().invert()).y < 0 ? -1 : 1;
  return inward * (halfWidth(type, wheel) + 0.25 * type.radius);
}

function innerCorners(wheel, centre) {
  const { type, mount } = wheel;
  const inner = innerFace(wheel, centre);
  return [-0.7, 0.7].map((x) => new Vector3(x * type.radius, inner, 0).applyMatrix4(mount));
}

// From the outer face of the hub to the chassis.
function axleGeometry(wheel, centre) {
  const { type, mount } = wheel;
  const [inner, outer] = [innerFace(wheel, centre), halfWidth(type, wheel.wheel)];
  const thick = 0.12 * type.radius;
  const geometry = new CylinderGeometry(thick, thick, Math.abs(inner) + outer, 24);
  return geometry.translate(0, (inner - Math.sign(inner) * outer) / 2, 0).applyMatrix4(mount);
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
