// Where the machine is seen: floor, light, camera.

import {
  ACESFilmicToneMapping,
  BufferGeometry,
  CanvasTexture,
  Color,
  DirectionalLight,
  Fog,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  OrbitControls,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  PMREMGenerator,
  RepeatWrapping,
  RoomEnvironment,
  Scene,
  ShadowMaterial,
  SRGBColorSpace,
  Vector3,
  WebGLRenderer,
} from "vendor";

const CELLS = 160; // along the floor, which comes along with the machine

export class Stage {
  constructor(element, machine, motion) {
    Object.assign(this, { element, machine, motion, follows: true });
    const size = machine.size;
    this.renderer = new WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    element.append(this.renderer.domElement);

    this.scene = new Scene();
    const room = new PMREMGenerator(this.renderer);
    this.scene.environment = room.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.65;
    this.scene.fog = new Fog(0, 4 * size, 16 * size);
    this.scene.background = new Color();
    this.camera = new PerspectiveCamera(38, 1, 0.02 * size, 40 * size);
    this.camera.up.set(0, 0, 1);
    this.sun = sunFor(size);
    this.cell = cellFor(size);
    this.floor = floorFor(CELLS * this.cell);
    this.trace = traceOf(motion);
    this.scene.add(machine.group, this.sun, this.sun.target, this.floor, this.trace);

    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    Object.assign(this.controls, { minDistance: 0.3 * size, maxDistance: 12 * size });
    this.last = new Vector3();
    this.look();
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  // From front left and above, at the machine; from further away where the window is narrow.
  look() {
    const away = 1.15 * Math.max(1, this.element.clientHeight / this.element.clientWidth) * this.machine.size;
    this.controls.target.set(0, 0, 0.8 * this.machine.height);
    this.camera.position.set(1.75, 1.75, 1.3).multiplyScalar(away).add(this.controls.target);
  }

  recolour(colour) {
    this.stale = true;
    this.scene.background.set(colour("ground"));
    this.scene.fog.color.set(colour("ground"));
    this.trace.material.color.set(colour("trace"));
    const [ground] = this.floor.children;
    ground.material.map?.dispose();
    ground.material.map = gridTexture(colour("ground"), colour("grid"), this.renderer.capabilities.getMaxAnisotropy());
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    // The panel at the bottom hides that part of the view: centre the rest.
    this.camera.setViewOffset(width, height, 0, Math.round(0.15 * height), width, height);
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }

  // A picture is drawn only where something has changed: `stale`, or the camera.
  draw() {
    const { position } = this.machine;
    if (this.follows) {
      const moved = position.clone().sub(this.last);
      this.controls.target.add(moved);
      this.camera.position.add(moved);
    }
    this.last.copy(position);
    this.sun.target.position.copy(position);
    this.sun.position.copy(position).add(this.sun.userData.from);
    const snapped = (x) => this.cell * Math.round(x / this.cell); // the lines stay, their ends come along
    this.floor.position.set(snapped(position.x), snapped(position.y), 0);
    this.trace.geometry.setDrawRange(0, this.motion.row + 2);
    if (this.controls.update() || this.stale) this.renderer.render(this.scene, this.camera);
    this.stale = false;
  }
}

// 1, 2 or 5 times a power of ten, m: about a third of the machine.
function cellFor(size) {
  const power = 10 ** Math.floor(Math.log10(size / 3));
  return power * [5, 2, 1].find((factor) => factor * power <= size / 3);
}

function sunFor(size) {
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.userData.from = new Vector3(1.2, -0.8, 2.6).multiplyScalar(2 * size);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  const reach = 1.5 * size;
  Object.assign(sun.shadow.camera, {
    left: -reach,
    right: reach,
    top: reach,
    bottom: -reach,
    near: 0.1 * size,
    far: 12 * size,
  });
  sun.shadow.bias = -0.0005;
  sun.shadow.radius = 3;
  return sun;
}

// The ground with its grid, in its own colours, and the shadow on it.
function floorFor(width) {
  const plane = new PlaneGeometry(width, width);
  const ground = new Mesh(
    plane,
    new MeshBasicMaterial({ toneMapped: false, depthWrite: false, map: new CanvasTexture() }),
  );
  const shadow = new Mesh(plane, new ShadowMaterial({ opacity: 0.35, depthWrite: false }));
  ground.renderOrder = -1;
  shadow.receiveShadow = true;
  return new Group().add(ground, shadow);
}

// One cell with half a line along each edge.
function gridTexture(ground, grid, anisotropy) {
  const size = 256;
  const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const pen = canvas.getContext("2d");
  pen.fillStyle = ground;
  pen.fillRect(0, 0, size, size);
  Object.assign(pen, { strokeStyle: grid, lineWidth: 0.016 * size });
  pen.strokeRect(0, 0, size, size);
  const texture = new CanvasTexture(canvas);
  Object.assign(texture, { wrapS: RepeatWrapping, wrapT: RepeatWrapping, colorSpace: SRGBColorSpace, anisotropy });
  texture.repeat.set(CELLS, CELLS);
  return texture;
}

// The path of the chassis origin, or of the wheel centre, on the floor.
function traceOf(motion) {
  const [x, y] = [0, 1].map((i) => motion.column("body/position", i));
  const points = x.map((_, row) => new Vector3(x[row], y[row], 0.001));
  const line = new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ toneMapped: false }));
  line.frustumCulled = false;
  return line;
}
