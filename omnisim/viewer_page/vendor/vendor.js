// What the page needs of three.js and uPlot, as one module: vendor.min.js. To renew it, in this folder:
//   npm install --no-save three uplot esbuild
//   npx esbuild vendor.js --bundle --minify --format=esm --legal-comments=none --outfile=vendor.min.js
//   cp node_modules/uplot/dist/uPlot.min.css . && rm -r node_modules
// and put the versions and licences into LICENSES.txt.
export {
  ACESFilmicToneMapping,
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  CircleGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DirectionalLight,
  EdgesGeometry,
  Fog,
  Group,
  InstancedMesh,
  LatheGeometry,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  PMREMGenerator,
  RepeatWrapping,
  RingGeometry,
  Scene,
  ShadowMaterial,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";
export { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
export { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
export { default as uPlot } from "uplot";
