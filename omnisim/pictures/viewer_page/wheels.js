// Wheels as solids. Axes of a wheel: x heading, y axle (left), z up; the roller's own axis is the y of its geometry.

import {
  BoxGeometry,
  BufferAttribute,
  CircleGeometry,
  CylinderGeometry,
  DataTexture,
  LatheGeometry,
  LinearFilter,
  Matrix4,
  RepeatWrapping,
  Vector2,
  Vector3,
  mergeGeometries,
} from "vendor";

// Segments around a roller and rows along it, coarsest first: each outline is about half as far from round as the last.
const DETAILS = [
  { segments: 12, rows: 5 },
  { segments: 16, rows: 9 },
  { segments: 24, rows: 9 },
  { segments: 32, rows: 17 },
  { segments: 48, rows: 17 },
];
const OFF_ROUND = 0.3; // pixels that nobody sees
const STRIPE = [0, 0.5]; // where around a roller bright stripes show how it turns
const PLAIN = 0.25; // where there is none

// The coarsest detail that looks exact where a metre takes that many pixels.
export function detailFor({ radius, rollers, profile }, pixels) {
  const chord = (r, angle) => r * (1 - Math.cos(angle / 2)); // how far its middle is from the arc, m
  const offRound = ({ segments, rows }) =>
    Math.max(chord(thickest(profile), (2 * Math.PI) / segments), chord(radius, (2 * Math.PI) / rollers / (rows - 1)));
  return DETAILS.find((detail) => offRound(detail) * pixels < OFF_ROUND) ?? DETAILS.at(-1);
}

// A roller: its profile [[u, r], ...] turned about its axis, closed by discs, on a pin. One with corners has another
// number of points, all of which are needed.
export function rollerGeometry({ profile }, { segments, rows }) {
  const stride = (profile.length - 1) / (rows - 1);
  const chosen = Number.isInteger(stride) ? profile.filter((_, i) => i % stride === 0) : profile;
  const surface = new LatheGeometry(
    chosen.map(([u, r]) => new Vector2(r, u)),
    segments,
  );
  const [length] = profile.at(-1);
  const middle = thickest(profile);
  const ends = [profile[0], profile.at(-1)].map(([u, r]) =>
    new CircleGeometry(Math.max(r, 1e-9), segments).rotateX((-Math.sign(u) * Math.PI) / 2).translate(0, u, 0),
  );
  const pin = new CylinderGeometry(0.15 * middle, 0.15 * middle, 2 * length + 0.25 * middle, segments / 2);
  return mergeGeometries([surface, ...[...ends, pin].map(plain)]);
}

// Once around a roller: what its colour is multiplied with, of at most 3.
export function stripes() {
  const [width, texels] = [32, new Uint8Array(4 * 32).fill(85)];
  for (const place of STRIPE) texels.fill(255, 4 * width * place, 4 * (width * place + 2));
  const texture = new DataTexture(texels, width, 1);
  Object.assign(texture, { magFilter: LinearFilter, minFilter: LinearFilter, wrapS: RepeatWrapping });
  texture.needsUpdate = true;
  return texture;
}

// What carries the rollers, as plain as can be: a hub, and an ear to either tip of each roller.
export function hubGeometry(type, wheel, { segments }) {
  const { radius, rollerDistance, rollers, profile } = type;
  const [length] = profile.at(-1);
  const middle = thickest(profile);
  const pinned = length + 0.08 * middle; // along the pin, beyond the roller's end
  const aside = outermost(type); // of its rows
  const side = Math.abs(pinned * Math.sin(wheel.psi)) + aside;
  const hub = Math.max(rollerDistance - 1.12 * middle, 0.3 * rollerDistance);
  const parts = [new CylinderGeometry(hub, hub, 2 * Math.max(side, 0.7 * middle + aside), 2 * segments)];
  if (side - aside > middle) {
    const plate = Math.max(rollerDistance - 0.35 * middle, hub);
    const disc = new CylinderGeometry(plate, plate, 0.16 * middle, 2 * segments);
    for (const y of [-side, side]) parts.push(disc.clone().translate(0, y, 0));
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
// Rows of rollers take turns.
export function rollerFrame({ rollerDistance, rollers, rows }, { psi, phase }, i) {
  const row = rows[i % rows.length];
  const q = phase + row.phase + (2 * Math.PI * Math.floor(i / rows.length) * rows.length) / rollers;
  const d = new Vector3(Math.sin(q), 0, -Math.cos(q));
  const axis = new Vector3(-Math.cos(psi) * Math.cos(q), Math.sin(psi), -Math.cos(psi) * Math.sin(q));
  const across = new Vector3().crossVectors(axis, d);
  const frame = new Matrix4().makeBasis(across, axis, d.clone());
  return frame.setPosition(d.multiplyScalar(rollerDistance).add(new Vector3(0, row.offset, 0)));
}

// Half the width of a wheel along its axle.
export function halfWidth(type, { psi }) {
  const [length] = type.profile.at(-1);
  return Math.max(Math.abs(length * Math.sin(psi)), thickest(type.profile)) + outermost(type);
}

function outermost({ rows }) {
  return Math.max(0, ...rows.map(({ offset }) => Math.abs(offset)));
}

function thickest(profile) {
  return Math.max(...profile.map(([, r]) => r));
}

function plain(geometry) {
  const count = geometry.attributes.position.count;
  return geometry.setAttribute("uv", new BufferAttribute(new Float32Array(2 * count).fill(PLAIN), 2));
}
