// Contact points, and forces and slip there as arrows; drawn over the wheel that would hide them.

import { ConeGeometry, CylinderGeometry, Group, Matrix4, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from "vendor";

export const KINDS = ["normal", "friction", "slip"];
const LONGEST = 1.7; // wheel radii, for the largest of the run
const STILL = 0.01; // m/s: slip below is no slip worth the longest arrow
const HEAD = 0.22; // of a wheel radius, as long as an arrow permits
const ALONG = new Vector3(0, 1, 0);

export class Arrows {
  constructor(machine, motion) {
    Object.assign(this, { machine, motion, group: new Group() });
    this.radius = machine.height;
    this.perNewton = (LONGEST * this.radius) / Math.max(this.largest("normal_force", 1), 1e-9);
    this.perSpeed = (LONGEST * this.radius) / Math.max(this.largest("slip_velocity", 2), STILL);
    this.materials = Object.fromEntries([...KINDS, "point"].map((kind) => [kind, onTop()]));
    this.wheels = machine.wheels.map(() => {
      const arrows = Object.fromEntries(KINDS.map((kind) => [kind, new Arrow(this.materials[kind], this.radius)]));
      const ring = new RingGeometry(0.05 * this.radius, 0.1 * this.radius, 32);
      const point = new Mesh(ring, this.materials.point);
      this.group.add(point, ...Object.values(arrows).map((arrow) => arrow.group));
      return { arrows, point };
    });
    this.shown = new Set(KINDS);
  }

  largest(name, width) {
    const lengths = this.machine.wheels.flatMap(({ path }) => {
      const columns = Array.from({ length: width }, (_, i) => this.motion.column(`${path}/${name}`, i));
      return columns[0].map((_, row) => Math.hypot(...columns.map((column) => column[row])));
    });
    return lengths.reduce((a, b) => Math.max(a, b), 0);
  }

  recolour(colour) {
    for (const kind of KINDS) this.materials[kind].color.set(colour(kind));
    this.materials.point.color.set(colour("text"));
  }

  // Returns the largest of each kind at this time, over the wheels: N, N, m/s.
  update() {
    const largest = { normal: 0, friction: 0, slip: 0 };
    this.machine.wheels.forEach((wheel, w) => {
      const at = (name, i) => this.motion.linear(`${wheel.path}/${name}`, i);
      const normal = at("normal_force");
      const vectors = {
        normal: new Vector3(0, 0, normal),
        friction: new Vector3(at("friction_force", 0), at("friction_force", 1), 0),
        slip: new Vector3(at("slip_velocity", 0), at("slip_velocity", 1), 0),
      };
      const point = wheel.contactPoint();
      const lift = 0.01 * this.radius;
      const turned = new Matrix4().extractRotation(wheel.frame); // from h, k, n to the world
      const { arrows, point: mark } = this.wheels[w];
      mark.position.copy(point).setZ(lift);
      mark.visible = normal > 0;
      for (const kind of KINDS) {
        const vector = vectors[kind];
        largest[kind] = Math.max(largest[kind], normal > 0 ? vector.length() : 0);
        vector.multiplyScalar(kind === "slip" ? this.perSpeed : this.perNewton).applyMatrix4(turned);
        arrows[kind].point(mark.position, vector, this.shown.has(kind) && normal > 0);
      }
    });
    return largest;
  }
}

class Arrow {
  constructor(material, radius) {
    this.radius = radius;
    this.shaft = new Mesh(new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0), material);
    this.head = new Mesh(new ConeGeometry(1, 1, 20).translate(0, 0.5, 0), material);
    this.group = new Group();
    this.group.add(this.shaft, this.head);
    this.group.renderOrder = this.shaft.renderOrder = this.head.renderOrder = 1;
  }

  // From a point along a vector, m.
  point(from, vector, shown) {
    const length = vector.length();
    this.group.visible = shown && length > 0.02 * this.radius;
    if (!this.group.visible) return;
    const head = Math.min(HEAD * this.radius, 0.6 * length);
    this.group.position.copy(from);
    this.group.quaternion.setFromUnitVectors(ALONG, vector.divideScalar(length));
    this.shaft.scale.set(0.13 * head, length - head, 0.13 * head);
    this.head.scale.set(0.34 * head, head, 0.34 * head);
    this.head.position.y = length - head;
  }
}

function onTop() {
  return new MeshBasicMaterial({ depthTest: false, transparent: true, toneMapped: false, fog: false });
}
