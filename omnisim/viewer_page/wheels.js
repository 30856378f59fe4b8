// Wheels as solids. Axes of a wheel: x heading, y axle (left), z up; the roller's own axis is the y of its geometry.

import {
  BoxGeometry,
  BufferAttribute,
  CircleGeometry,
  CylinderGeometry,
  LatheGeometry,
  Matrix4,
  Vector2,
  Vector3,
  mergeGeometries,
} from "vendor";

const SEGMENTS = 32; // around a roller
const STRIPE = 16; // every so many segments a bright one shows how the roller turns

// The exact roller: its profile [[u, r], ...] turned about its axis, closed by discs, on a pin.
export function rollerGeometry({ profile }) {
  const surface = new LatheGeometry(
    profile.map(([u, r]) => new Vector2(r, u)),
    SEGMENTS,
  );
  const rows = profile.length;
  const colours = new Float32Array(3 * rows * (SEGMENTS + 1));
  for (let i = 0; i <= SEGMENTS; i++) colours.fill(i % STRIPE < 2 ? 3 : 1, 3 * rows * i, 3 * rows * (i + 1));
  surface.setAttribute("color", new BufferAttribute(colours, 3));
  const [length, tip] = profile.at(-1);
  const middle = Math.max(...profile.map(([, r]) => r));
  const ends = [-1, 1].map((side) =>
    new CircleGeometry(Math.max(tip, 1e-9), SEGMENTS).rotateX((-side * Math.PI) / 2).translate(0, side * length, 0),
  );
  const pin = new CylinderGeometry(0.15 * middle, 0.15 * middle, 2 * length + 0.25 * middle, 12);
  return mergeGeometries([surface, ...[...ends, pin].map(white)]);
}

// What carries the rollers, as plain as can be: a hub, and an ear to either tip of each roller.
export function hubGeometry(type, wheel) {
  const { radius, rollerDistance, rollers, profile } = type;
  const [length] = profile.at(-1);
  const middle = Math.max(...profile.map(([, r]) => r));
  const pinned = length + 0.08 * middle; // along the pin, beyond the roller's end
  const side = Math.abs(pinned * Math.sin(wheel.psi));
  const hub = Math.max(rollerDistance - 1.12 * middle, 0.3 * rollerDistance);
  const parts = [new CylinderGeometry(hub, hub, 2 * Math.max(side, 0.7 * middle), 48)];
  if (side > middle) {
    const plate = Math.max(rollerDistance - 0.35 * middle, hub);
    for (const y of [-side, side]) parts.push(new CylinderGeometry(plate, plate, 0.16 * middle, 48).translate(0, y, 0));
  }
  for (let i = 0; i < rollers; i++) {
    const frame = rollerFrame(type, wheel, i);
    for (const end of [-pinned, pinned]) {
      const tip = new Vector3(0, end, 0).applyMatrix4(frame);
      const reach = Math.min(Math.hypot(tip.x, tip.z), 0.95 * radius);
      const ear = new BoxGeometry(0.3 * middle, 0.12 * middle, reach).translate(0, tip.y, reach / 2);
      parts.push(ear.rotateY(Math.atan2(tip.x, tip.z)));
    }
  }
  return mergeGeometries(parts);
}

// Where roller i sits in its wheel at spin angle 0: d = -cos q n + sin q h, axis c t + s k with t = k x d.
export function rollerFrame({ rollerDistance, rollers }, { psi, phase }, i) {
  const q = phase + (2 * Math.PI * i) / rollers;
  const d = new Vector3(Math.sin(q), 0, -Math.cos(q));
  const axis = new Vector3(-Math.cos(psi) * Math.cos(q), Math.sin(psi), -Math.cos(psi) * Math.sin(q));
  const across = new Vector3().crossVectors(axis, d);
  return new Matrix4().makeBasis(across, axis, d.clone()).setPosition(d.multiplyScalar(rollerDistance));
}

// Half the width of a wheel along its axle.
export function halfWidth({ profile }, { psi }) {
  const [length] = profile.at(-1);
  return Math.max(Math.abs(length * Math.sin(psi)), ...profile.map(([, r]) => r));
}

function white(geometry) {
  const count = geometry.attributes.position.count;
  return geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * count).fill(1), 3));
}
