// What carries wheels that move in the chassis: axles that slide on springs, and bars that turn about a pivot.

import {
  CylinderGeometry,
  Group,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  Quaternion,
  Vector3,
  mergeGeometries,
} from "vendor";
import { halfWidth } from "omnisim/wheels";

const COLOURS = { axle: 0x8b949c, spring: 0xf0c419 };
const THICK = 0.12; // of an axle, in wheel radii, as all here
const GAP = { fixed: 0.25, carried: 0.5 }; // from a wheel to the chassis
const COIL = { radius: 0.16, wire: 0.035, turns: 5, top: 0.9, least: 0.05 }; // top: above the wheel centre
const BAR = 0.09; // thick
const PIN = 0.3; // beyond what turns on it
const ALONG = new Vector3(0, 1, 0); // axis of a cylinder

// Where along the axle of a wheel the chassis begins, seen from the wheel centre, towards the middle of the machine.
export function innerFace({ wheel, type, mount, sprung }, centre) {
  const inward = centre.clone().applyMatrix4(mount.clone().invert()).y < 0 ? -1 : 1;
  const gap = sprung || wheel.rocker ? GAP.carried : GAP.fixed;
  return inward * (halfWidth(type, wheel) + gap * type.radius);
}

// The middle of the gap between a wheel and the chassis.
export function insideGap(wheel, centre) {
  const face = innerFace(wheel, centre);
  return face - 0.5 * Math.sign(face) * GAP.carried * wheel.type.radius;
}

// From the outer face of the hub to the chassis.
export function axleGeometry(wheel, centre) {
  const { type, mount } = wheel;
  const [inner, outer] = [innerFace(wheel, centre), halfWidth(type, wheel.wheel)];
  const thick = THICK * type.radius;
  const geometry = new CylinderGeometry(thick, thick, Math.abs(inner) + outer, 24);
  return geometry.translate(0, (inner - Math.sign(inner) * outer) / 2, 0).applyMatrix4(mount);
}

// How high springs reach above the centre of a wheel.
export const springTop = ({ type }) => COIL.top * type.radius;

// Parts of the chassis that move in it, to be put where they are by `update` once their wheels are.
export class Carriers {
  constructor(wheels, centre) {
    this.group = new Group();
    this.moving = []; // parts, and the wheel that they move with
    this.springs = wheels.filter(({ sprung }) => sprung).map((wheel) => new Spring(wheel, centre));
    for (const { wheel, coil } of this.springs) {
      this.moves(wheel, axleGeometry(wheel, centre));
      this.group.add(coil);
    }
    const rockers = new Set(wheels.flatMap(({ wheel }) => wheel.rocker?.name ?? []));
    for (const name of rockers) {
      const both = wheels.filter(({ wheel }) => wheel.rocker?.name === name);
      this.moves(both[0], rockerGeometry(both, centre));
    }
  }

  moves(wheel, geometry) {
    const part = solid(geometry, COLOURS.axle);
    this.group.add(part);
    this.moving.push({ wheel, part });
  }

  update() {
    for (const { wheel, part } of this.moving) part.matrix.copy(wheel.carrier);
    for (const spring of this.springs) spring.update();
  }
}

// A coil between the axle of a wheel and what holds it above.
class Spring {
  constructor(wheel, centre) {
    const { radius } = wheel.type;
    Object.assign(this, { wheel, length: springTop(wheel) - THICK * radius });
    this.foot = new Matrix4().setPosition(0, insideGap(wheel, centre), THICK * radius).premultiply(wheel.mount);
    this.coil = solid(coilGeometry(radius, this.length), COLOURS.spring);
  }

  // As long as the travel of the wheel leaves it.
  update() {
    const { carrier, type } = this.wheel;
    this.left = Math.max(this.length - carrier.elements[14], COIL.least * type.radius);
    const stretch = new Matrix4().makeScale(1, 1, this.left / this.length);
    this.coil.matrix.multiplyMatrices(carrier, this.foot).multiply(stretch);
  }
}

// A rod wound around z, upwards from 0.
function coilGeometry(size, length) {
  const { radius, wire, turns } = COIL;
  const geometry = new CylinderGeometry(wire * size, wire * size, 1, 8, 20 * turns);
  const places = geometry.attributes.position;
  for (let i = 0; i < places.count; i++) {
    const [out, along] = [radius * size + places.getX(i), places.getY(i) + 0.5];
    const turn = 2 * Math.PI * turns * along;
    places.setXYZ(i, out * Math.cos(turn), out * Math.sin(turn), length * along + places.getZ(i));
  }
  geometry.computeVertexNormals();
  return geometry;
}

// The axles of both wheels, bars from them to the pivot, and the pin about which it turns.
function rockerGeometry(wheels, centre) {
  const { axis, point } = wheels[0].wheel.rocker;
  const [along, pivot, { radius }] = [new Vector3(...axis), new Vector3(...point), wheels[0].type];
  const ends = wheels.map((wheel) => new Vector3(0, insideGap(wheel, centre), 0).applyMatrix4(wheel.mount));
  const reach = [0, ...ends.map((end) => end.clone().sub(pivot).dot(along))];
  const [from, to] = [Math.min(...reach) - PIN * radius, Math.max(...reach) + PIN * radius];
  const pin = [from, to].map((far) => pivot.clone().addScaledVector(along, far));
  const middle = pivot.clone().addScaledVector(along, (from + to) / 2);
  return mergeGeometries([
    ...wheels.map((wheel) => axleGeometry(wheel, centre)),
    ...ends.map((end) => rod(end, middle, BAR * radius)),
    rod(...pin, THICK * radius),
  ]);
}

// A cylinder from one point to another.
function rod(from, to, thick) {
  const way = to.clone().sub(from);
  const length = way.length();
  const turn = new Quaternion().setFromUnitVectors(ALONG, way.normalize());
  const place = new Matrix4().makeRotationFromQuaternion(turn).setPosition(from.clone().add(to).multiplyScalar(0.5));
  return new CylinderGeometry(thick, thick, length, 24).applyMatrix4(place);
}

function solid(geometry, color) {
  const mesh = new Mesh(geometry, new MeshLambertMaterial({ color }));
  mesh.matrixAutoUpdate = false;
  return mesh;
}
