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
  CircleGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DataTexture,
  DirectionalLight,
  EdgesGeometry,
  EqualStencilFunc,
  Fog,
  Group,
  HemisphereLight,
  IncrementStencilOp,
  InstancedMesh,
  LatheGeometry,
  Line,
  LineBasicMaterial,
  LineSegments,
  LinearFilter,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  MeshPhongMaterial,
  PerspectiveCamera,
  PlaneGeometry,
  Quaternion,
  RepeatWrapping,
  RingGeometry,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
export { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
export { default as uPlot } from "uplot";
