// Uneven ground: a mesh of its points, with the lines of the grid laid over it.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  LinearFilter,
  Mesh,
  MeshBasicMaterial,
  RepeatWrapping,
} from "vendor";
import { decoded } from "omnisim/motion";

const TEXELS = 64; // of a cell of the grid
const RELIEF = 2.5; // how much more than in reality slopes are bright or dark
const SHADES = [0.35, 1.25]; // darkest and brightest, of level ground

export class Ground {
  // Points [a, b, 3] as the file has them; the side of a cell, m; a vector to the light.
  constructor(points, cell, light) {
    const [rows, columns] = points.shape;
    const { values } = decoded(points);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(values, 3));
    const uv = new Float32Array(2 * rows * columns);
    for (let i = 0; i < rows * columns; i++) uv.set([values[3 * i] / cell, values[3 * i + 1] / cell], 2 * i);
    geometry.setAttribute("uv", new BufferAttribute(uv, 2));
    const corners = [];
    for (let i = 0; i + 1 < rows; i++)
      for (let j = 0; j + 1 < columns; j++) {
        const at = i * columns + j;
        corners.push(at, at + columns, at + 1, at + 1, at + columns, at + columns + 1);
      }
    geometry.setIndex(corners);
    geometry.computeVertexNormals();
    geometry.setAttribute("color", shades(geometry.attributes.normal, light));
    const material = new MeshBasicMaterial({ map: lines(), vertexColors: true, toneMapped: false });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
  }

  recolour(ground) {
    this.mesh.material.color.set(new Color(ground));
  }
}

// How bright each point is: level ground as it is, the rest by how it faces the light.
function shades(normals, light) {
  const found = new Float32Array(3 * normals.count);
  for (let i = 0; i < normals.count; i++) {
    const facing = (normals.getX(i) * light.x + normals.getY(i) * light.y) / light.z + normals.getZ(i);
    found.fill(Math.min(Math.max(1 + RELIEF * (facing - 1), SHADES[0]), SHADES[1]), 3 * i, 3 * i + 3);
  }
  return new BufferAttribute(found, 3);
}

// A cell: bright, darker along two of its sides.
function lines() {
  const texels = new Uint8Array(4 * TEXELS * TEXELS).fill(255);
  for (let i = 0; i < TEXELS; i++)
    for (const at of [i, i * TEXELS]) texels.fill(175, 4 * at, 4 * at + 3);
  const texture = new DataTexture(texels, TEXELS, TEXELS);
  Object.assign(texture, { magFilter: LinearFilter, minFilter: LinearFilter, generateMipmaps: false });
  Object.assign(texture, { wrapS: RepeatWrapping, wrapT: RepeatWrapping, needsUpdate: true });
  return texture;
}
