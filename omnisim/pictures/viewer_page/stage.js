// Where the machine is seen: floor, light, camera.

import {
  ACESFilmicToneMapping,
  BufferGeometry,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  InstancedMesh,
  Line,
  LineBasicMaterial,
  Matrix4,
  MeshBasicMaterial,
  OrbitControls,
  PerspectiveCamera,
  PlaneGeometry,
  Scene,
  Vector3,
  WebGLRenderer,
} from "vendor";
import { Ground } from "omnisim/ground";
import { shadowOf } from "omnisim/shadow";

const SUN = new Vector3(1.2, -0.8, 2.6); // towards it
const FIELD = (38 * Math.PI) / 180; // of view, upwards
const FOG = [1.1, 3.5]; // where it begins and ends, in distances from the machine
const REACH = 12; // of the grid, in sizes of the machine
const LINE = 1.5; // width in pixels, at the machine

export class Stage {
  // ground: points of uneven ground, if it is; up: against gravity, where that is not z.
  constructor(element, machine, motion, changed, { ground, up = [0, 0, 1] }) {
    Object.assign(this, { element, machine, motion, changed, follows: true });
    const size = machine.size;
    this.renderers = new Map(); // a canvas smooths edges or not, for good: one of each kind
    this.rendererFor(true);
    this.scene = new Scene();
    this.scene.fog = new Fog(0);
    this.scene.background = new Color();
    this.camera = new PerspectiveCamera((180 / Math.PI) * FIELD, 1, 0.02 * size, 40 * size);
    this.camera.up.set(...up);
    this.cell = cellFor(size);
    this.grid = new Grid(this.cell, REACH * size);
    this.trace = traceOf(motion);
    const [sun, sky] = [new DirectionalLight(0xffffff, 2.2), new HemisphereLight(0xffffff, 0xb8c0c8, 3.4)];
    sun.position.copy(SUN);
    sky.position.set(0, 0, 1);
    this.scene.add(machine.group, sun, sky, this.trace);
    if (ground) {
      this.ground = new Ground(ground, this.cell, SUN);
      this.scene.add(this.ground.mesh); // too uneven for a shadow that is laid flat
    } else this.scene.add(shadowOf(machine.group, SUN), this.grid.mesh);

    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = true;
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    Object.assign(this.controls, { minDistance: 0.3 * size, maxDistance: 6 * size });
    this.controls.addEventListener("change", changed);
    this.last = new Vector3();
    this.look();
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  // From front left and above, at the machine; from further away where the window is narrow.
  look() {
    const away = Math.max(0.85, (1.15 * this.element.clientHeight) / this.element.clientWidth) * this.machine.size;
    this.controls.target.set(0, 0, 0.9 * this.machine.height);
    this.camera.position.set(1.75, 1.75, 1.3).multiplyScalar(away).add(this.controls.target);
  }

  recolour(colour) {
    this.scene.background.set(colour("ground"));
    this.scene.fog.color.set(colour("ground"));
    this.ground?.recolour(colour("ground"));
    this.trace.material.color.set(colour("trace"));
    this.grid.mesh.material.color.set(colour("grid"));
    this.changed();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  // A picture, of a part of the screen's pixels along each side.
  draw({ antialias, part }) {
    const { camera, controls, element, grid, machine, scene } = this;
    const { position } = machine;
    if (this.follows) {
      const moved = position.clone().sub(this.last);
      controls.target.add(moved);
      camera.position.add(moved);
    }
    this.last.copy(position);
    controls.update();
    const renderer = this.rendererFor(antialias);
    const [canvas, ratio] = [renderer.domElement, part * Math.min(devicePixelRatio, 2)];
    const [width, height] = [element.clientWidth, element.clientHeight];
    if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio))
      renderer.setDrawingBufferSize(width, height, ratio);
    const pixels = canvas.height / (2 * Math.tan(FIELD / 2)); // of a metre at a distance of a metre
    const distance = controls.getDistance();
    machine.refine(camera.position, pixels);
    grid.update(position, (LINE * distance) / pixels);
    Object.assign(scene.fog, { near: FOG[0] * distance, far: Math.min(FOG[1] * distance, REACH * machine.size) });
    this.trace.geometry.setDrawRange(0, this.motion.row + 2);
    renderer.render(scene, camera);
    if (canvas.parentElement !== element) element.replaceChildren(canvas);
  }

  rendererFor(antialias) {
    if (!this.renderers.has(antialias)) {
      const renderer = new WebGLRenderer({ antialias, stencil: true });
      renderer.toneMapping = ACESFilmicToneMapping;
      this.renderers.set(antialias, renderer);
    }
    return this.renderers.get(antialias);
  }
}

// 1, 2 or 5 times a power of ten, m: about a third of the machine.
function cellFor(size) {
  const power = 10 ** Math.floor(Math.log10(size / 3));
  return power * [5, 2, 1].find((factor) => factor * power <= size / 3);
}

// Lines on the floor as thin faces: where a line of one pixel leaves the view, software WebGL drops it altogether.
class Grid {
  constructor(cell, reach) {
    const n = Math.ceil(reach / cell);
    Object.assign(this, { cell, n, length: 2 * n * cell });
    const material = new MeshBasicMaterial({ toneMapped: false, depthWrite: false });
    this.mesh = new InstancedMesh(new PlaneGeometry(1, 1), material, 2 * (2 * n + 1));
    Object.assign(this.mesh, { frustumCulled: false, renderOrder: -1 });
  }

  // Around a point, m; the lines stay where they are while their ends come along.
  update({ x, y }, width) {
    const { cell, mesh, n, length } = this;
    const [cx, cy] = [cell * Math.round(x / cell), cell * Math.round(y / cell)];
    const line = new Matrix4();
    for (let i = -n; i <= n; i++) {
      mesh.setMatrixAt(n + i, line.makeScale(width, length, 1).setPosition(cx + i * cell, cy, 0));
      mesh.setMatrixAt(3 * n + 1 + i, line.makeScale(length, width, 1).setPosition(cx, cy + i * cell, 0));
    }
    mesh.instanceMatrix.needsUpdate = true;
  }
}

// The path of the chassis origin, or of the wheel centre, on the floor.
function traceOf(motion) {
  const [x, y] = [0, 1].map((i) => motion.column("body/position", i));
  const z = motion.has("trace_height") ? motion.column("trace_height") : x.map(() => 0.001);
  const points = x.map((_, row) => new Vector3(x[row], y[row], z[row]));
  const line = new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ toneMapped: false }));
  line.frustumCulled = false;
  return line;
}
