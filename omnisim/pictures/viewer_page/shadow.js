// The shadow on the floor: the same meshes once more, laid flat along the light. A shadow map costs several times more.

import { EqualStencilFunc, Group, IncrementStencilOp, MeshBasicMaterial } from "vendor";

const FLATTENED = 1e-3; // of a height: not to nothing, or front and back of a face were up to rounding

// Of a group, from light in a direction (a vector to the light). It shares geometry and matrices, so it moves along.
export function shadowOf(group, light) {
  const shade = new MeshBasicMaterial({
    color: 0,
    opacity: 0.35,
    transparent: true,
    depthWrite: false,
    stencilWrite: true, // once where parts lie over each other
    stencilFunc: EqualStencilFunc,
    stencilRef: 0,
    stencilZPass: IncrementStencilOp,
  });
  const [x, y] = [-light.x / light.z, -light.y / light.z];
  const shadow = new Group().add(flat(group, shade));
  shadow.matrix.set(1, 0, x, 0, 0, 1, y, 0, 0, 0, FLATTENED, 0, 0, 0, 0, 1);
  shadow.matrixAutoUpdate = false;
  return shadow;
}

function flat(part, shade) {
  const twin = part.clone(false);
  Object.assign(twin, { matrix: part.matrix, material: shade });
  if (part.isInstancedMesh) Object.assign(twin, { instanceMatrix: part.instanceMatrix, instanceColor: null });
  for (const name of ["visible", "geometry"]) Object.defineProperty(twin, name, { get: () => part[name] });
  for (const child of part.children) if (!child.isLine) twin.add(flat(child, shade));
  return twin;
}
