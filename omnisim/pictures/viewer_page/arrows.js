// Contact points, and forces and slip there as arrows; drawn over the wheel that would hide them.

import {
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  Quaternion,
  RingGeometry,
  Vector3,
} from "vendor";

export const KINDS = ["normal", "friction", "slip"];
const LONGEST = 1.7; // wheel radii, for the largest of the run
const STILL = 0.01; // m/s: slip below is no slip worth the longest arrow
const HEAD = 0.22; // of a wheel radius, as long as an arrow permits
const ALONG = new Vector3(0, 1, 0);
const NOWHERE = new Matrix4().makeScale(0, 0, 0);

export class Arrows {
  constructor(machine, motion) {
    Object.assign(this, { machine, motion });
    this.radius = machine.height;
    this.perNewton = (LONGEST * this.radius) / Math.max(this.largest("normal_force", 1), 1e-9);
    this.perSpeed = (LONGEST * this.radius) / Math.max(this.largest("slip_velocity", 2), STILL);
    const [wheels, arrows] = [machine.wheels.length, machine.wheels.length * KINDS.length];
    this.points = onTop(new RingGeometry(0.05 * this.radius, 0.1 * this.radius, 32), wheels);
    this.shafts = onTop(new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0), arrows);
    this.heads = onTop(new ConeGeometry(1, 1, 20).translate(0, 0.5, 0), arrows);
    this.group = new Group().add(this.points, this.shafts, this.heads);
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
    this.points.material.color.set(colour("text"));
    const colours = KINDS.map((kind) => new Color(colour(kind)));
    for (const mesh of [this.shafts, this.heads]) {
      for (let i = 0; i < mesh.count; i++) mesh.setColorAt(i, colours[i % KINDS.length]);
      mesh.instanceColor.needsUpdate = true;
    }
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
      const up = wheel.normal();
      const turned = tangents(wheel.frame, up); // from h, k, n to the world
      const point = wheel.contactPoint().addScaledVector(up, 0.01 * this.radius);
      this.points.setMatrixAt(w, normal > 0 ? turned.clone().setPosition(point) : NOWHERE);
      KINDS.forEach((kind, k) => {
        const vector = vectors[kind];
        largest[kind] = Math.max(largest[kind], normal > 0 ? vector.length() : 0);
        vector.multiplyScalar(kind === "slip" ? this.perSpeed : this.perNewton).applyMatrix4(turned);
        this.point(w * KINDS.length + k, point, vector, this.shown.has(kind) && normal > 0);
      });
    });
    for (const mesh of this.group.children) mesh.instanceMatrix.needsUpdate = true;
    return largest;
  }

  // Arrow i, from a point along a vector, m.
  point(i, from, vector, shown) {
    const length = vector.length();
    let [shaft, tip] = [NOWHERE, NOWHERE];
    if (shown && length > 0.02 * this.radius) {
      const head = Math.min(HEAD * this.radius, 0.6 * length);
      const turn = new Quaternion().setFromUnitVectors(ALONG, vector.divideScalar(length));
      const end = vector.multiplyScalar(length - head).add(from);
      shaft = new Matrix4().compose(from, turn, new Vector3(0.13 * head, length - head, 0.13 * head));
      tip = new Matrix4().compose(end, turn, new Vector3(0.34 * head, head, 0.34 * head));
    }
    this.shafts.setMatrixAt(i, shaft);
    this.heads.setMatrixAt(i, tip);
  }
}

// Axes at a contact: h = unit(axle x normal) along the ground, across it, and its normal.
function tangents(frame, up) {
  const axle = new Vector3().setFromMatrixColumn(frame, 1);
  const ahead = axle.cross(up).normalize();
  return new Matrix4().makeBasis(ahead, up.clone().cross(ahead), up);
}

function onTop(geometry, count) {
  const material = new MeshBasicMaterial({ depthTest: false, transparent: true, toneMapped: false, fog: false });
  const mesh = new InstancedMesh(geometry, material, count);
  Object.assign(mesh, { frustumCulled: false, renderOrder: 1 });
  return mesh;
}
