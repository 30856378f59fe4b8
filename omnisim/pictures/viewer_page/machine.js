// The machine: chassis, wheels and every roller, put where the motion has them.

import { Color, Group, InstancedMesh, Matrix4, Mesh, MeshPhongMaterial, Quaternion, Vector3 } from "vendor";
import { chassisOf } from "omnisim/chassis";
import { detailFor, hubGeometry, rollerFrame, rollerGeometry, stripes } from "omnisim/wheels";

const RUBBER = new Color(0x333940);
const TOUCHING = new Color(0xe07b1a);
const METAL = new Color(0xb4bcc4);
const IN_THE_AIR = new Color(0x5aaef0); // of a hub that nothing carries
const EDGE = 1e-6; // rad by which a roller at rest on its edge may seem beyond it
const UP = new Vector3(0, 0, 1);
const AXLE = new Vector3(0, 1, 0);

export class Machine {
  constructor({ types, wheels, chassis, free }, motion) {
    Object.assign(this, { motion, free });
    this.group = new Group();
    this.place = new Matrix4(); // of the chassis origin
    this.wheels = wheels.map((wheel) => new Wheel(wheel, types[wheel.type], motion, free));
    this.rollers = Object.entries(types).map(
      ([name, type]) =>
        new Rollers(
          type,
          this.wheels.filter(({ wheel }) => wheel.type === name),
        ),
    );
    this.group.add(...this.wheels.map(({ hub }) => hub), ...this.rollers.map(({ mesh }) => mesh));
    if (chassis) {
      const { group, carriers } = chassisOf(this.wheels);
      Object.assign(this, { chassis: group, carriers });
      this.group.add(group);
    }
    this.size = Math.max(...this.wheels.map(({ wheel, type }) => Math.hypot(...wheel.position) + 2 * type.radius));
    this.height = Math.max(...this.wheels.map(({ type }) => type.radius));
  }

  // Everything at the present time of the motion.
  update() {
    const at = (component) => this.motion.smooth("body/position", "body/velocity", component);
    this.position = new Vector3(at(0), at(1), this.free ? at(2) : 0);
    this.turn().setPosition(this.position);
    this.chassis?.matrix.copy(this.place);
    for (const wheel of this.wheels) wheel.update(this.place);
    this.carriers?.update();
    for (const rollers of this.rollers) rollers.update();
  }

  // Turns `place`: by the yaw, or as the quaternion w x y z says.
  turn() {
    if (!this.free) return this.place.makeRotationAxis(UP, this.motion.smooth("body/yaw", "body/yaw_rate"));
    const [w, x, y, z] = [0, 1, 2, 3].map((i) => this.motion.linear("body/orientation", i));
    return this.place.makeRotationFromQuaternion(new Quaternion(x, y, z, w).normalize());
  }

  // As fine as can be seen from a point, where a metre at a distance of a metre takes that many pixels.
  refine(eye, pixels) {
    for (const { type, wheels, mesh, geometryFor } of this.rollers) {
      const distances = wheels.map(({ frame }) => new Vector3().setFromMatrixPosition(frame).distanceTo(eye));
      const nearest = Math.max(Math.min(...distances) - type.radius, 0.1 * type.radius);
      const detail = detailFor(type, pixels / nearest);
      mesh.geometry = geometryFor(detail);
      for (const wheel of wheels) wheel.hub.geometry = wheel.geometryFor(detail);
    }
  }

  // Centre of roller i of wheel w, as drawn.
  rollerPosition(w, i) {
    const place = new Matrix4();
    for (const { drawn, mesh } of this.rollers) {
      const index = drawn.findIndex((one) => one.wheel === this.wheels[w] && one.i === i);
      if (index >= 0) mesh.getMatrixAt(index, place);
    }
    return new Vector3().setFromMatrixPosition(place);
  }
}

class Wheel {
  constructor(wheel, type, motion, free) {
    Object.assign(this, { wheel, type, motion, free, path: `wheels/${wheel.name}` });
    this.sprung = motion.has(`${this.path}/suspension_travel`);
    this.hub = new Mesh(undefined, new MeshPhongMaterial({ color: METAL, specular: 0x666666, shininess: 40 }));
    this.geometryFor = perDetail((detail) => hubGeometry(type, wheel, detail));
    this.hub.matrixAutoUpdate = false;
    const [x, y] = wheel.position;
    this.mount = new Matrix4().makeRotationAxis(UP, wheel.heading).setPosition(x, y, type.radius);
    this.frame = new Matrix4(); // heading, axle, up at the wheel centre
  }

  update(place) {
    this.spin = this.motion.smooth(`${this.path}/spin_angle`, `${this.path}/spin_rate`);
    this.carrier = this.carried();
    this.frame.multiplyMatrices(place, this.carrier).multiply(this.mount);
    this.hub.matrix.copy(this.frame).multiply(new Matrix4().makeRotationAxis(AXLE, this.spin));
    this.touching = this.free ? this.motion.held(`${this.path}/contact_roller`) : this.contactRoller();
    this.inTheAir = this.touching < 0;
    this.hub.material.color.copy(this.inTheAir ? IN_THE_AIR : METAL);
  }

  // How its suspension or its rocker has moved it in the chassis.
  carried() {
    const [travel, angle] = [`${this.path}/suspension_travel`, `${this.path}/rocker_angle`];
    if (this.sprung)
      return new Matrix4().setPosition(0, 0, this.motion.smooth(travel, `${this.path}/suspension_rate`));
    if (!this.motion.has(angle)) return new Matrix4();
    const [axis, point] = [this.wheel.rocker.axis, this.wheel.rocker.point].map((one) => new Vector3(...one));
    const turn = new Matrix4().makeRotationAxis(axis, this.motion.smooth(angle, `${this.path}/rocker_rate`));
    return turn.setPosition(point.clone().sub(point.clone().applyMatrix4(turn)));
  }

  azimuth(i) {
    const { rollers, rows } = this.type;
    const q = this.wheel.phase + rows[0].phase + (2 * Math.PI * i) / rollers - this.spin;
    return q - 2 * Math.PI * Math.round(q / (2 * Math.PI));
  }

  // Of an upright machine: that of the last row while it reaches the floor; else the nearest, which has taken over since.
  contactRoller() {
    const [recorded, n] = [this.motion.held(`${this.path}/contact_roller`), this.type.rollers];
    if (Math.abs(this.azimuth(recorded)) <= Math.PI / n + EDGE) return recorded;
    const nearest = Math.round((-this.azimuth(0) * n) / (2 * Math.PI));
    return (nearest + n) % n;
  }

  // Unit normal of the ground there.
  normal() {
    if (!this.motion.has(`${this.path}/contact_normal`)) return UP.clone();
    return new Vector3(...this.between("contact_normal")).normalize();
  }

  // A vector of the contact: from row to row, as long as the same roller touches.
  between(name) {
    const [before, after] = this.motion.around(`${this.path}/contact_roller`, 0);
    const read = before === after ? "linear" : "nearest";
    return [0, 1, 2].map((i) => this.motion[read](`${this.path}/${name}`, i));
  }

  // Where it touches: as it was recorded, along the way of one roller; or P = O - R n + (R1 tan q tan psi + offset) k.
  contactPoint() {
    if (this.free) return new Vector3(...this.between("contact_point"));
    const { radius, rollerDistance, rows } = this.type;
    const along = rollerDistance * Math.tan(this.azimuth(this.touching)) * Math.tan(this.wheel.psi);
    return new Vector3(0, along + rows[this.touching % rows.length].offset, -radius).applyMatrix4(this.frame);
  }
}

// Made at its first use.
function perDetail(make) {
  const made = new Map();
  return (detail) => made.get(detail) ?? made.set(detail, make(detail)).get(detail);
}

// All rollers of one type of wheel, mirrored or not: they have one geometry.
class Rollers {
  constructor(type, wheels) {
    const count = type.rollers;
    this.drawn = wheels.flatMap((wheel) =>
      Array.from({ length: count }, (_, i) => ({
        wheel,
        i,
        frame: rollerFrame(type, wheel.wheel, i),
        path: `${wheel.path}/rollers/joint_angle`,
      })),
    );
    Object.assign(this, { type, wheels, geometryFor: perDetail((detail) => rollerGeometry(type, detail)) });
    const material = new MeshPhongMaterial({ map: stripes(), specular: 0x333333, shininess: 20 });
    material.color.setScalar(3);
    this.mesh = new InstancedMesh(undefined, material, this.drawn.length);
    this.mesh.frustumCulled = false;
  }

  update() {
    const [place, turn] = [new Matrix4(), new Matrix4()];
    this.drawn.forEach(({ wheel, i, frame, path }, index) => {
      turn.makeRotationAxis(AXLE, wheel.motion.linear(path, i));
      this.mesh.setMatrixAt(index, place.multiplyMatrices(wheel.hub.matrix, frame).multiply(turn));
      this.mesh.setColorAt(index, i === wheel.touching ? TOUCHING : RUBBER);
    });
    this.mesh.instanceMatrix.needsUpdate = this.mesh.instanceColor.needsUpdate = true;
  }
}
