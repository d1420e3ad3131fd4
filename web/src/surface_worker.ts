// Triangles of a level by vtk.js, in a Worker of their own: the page stays live.

import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray.js';
import vtkImageData from '@kitware/vtk.js/Common/DataModel/ImageData.js';
import vtkImageMarchingCubes from '@kitware/vtk.js/Filters/General/ImageMarchingCubes.js';
import type { Vec3 } from './protocol';

export interface SurfaceRequest {
  key: string;
  level: number;
  dims: Vec3;
  values: Float32Array;
}

/** Positions in voxels; normals of the gradient there; triangles as vtkCellArray has them. */
export interface Surface {
  key: string;
  level: number;
  points: Float32Array;
  normals: Float32Array;
  triangles: Uint32Array;
}

// vtk.js prints its times.
console.time = console.timeEnd = () => {};

const least_part = 0.3; // of the largest part, in triangles. More: limbs are lost; less: tables and remains are drawn

/** Triangles of the large parts, as the native window has them: disjoint sets of points. */
function large_parts(triangles: Uint32Array, points: number): Uint32Array {
  const parent = Uint32Array.from({ length: points }, (_, n) => n), size = new Uint32Array(points);
  const root = (n: number) => {
    while (parent[n] !== n) n = parent[n] = parent[parent[n]];
    return n;
  };
  // vtkCellArray: 3, a, b, c, 3, …
  for (let t = 0; t < triangles.length; t += 4)
    for (let c = 2; c <= 3; ++c) parent[root(triangles[t + c])] = root(triangles[t + 1]);
  for (let t = 0; t < triangles.length; t += 4) ++size[root(triangles[t + 1])];
  const least = least_part * size.reduce((most, one) => Math.max(most, one), 0);
  if (size.every((one) => one === 0 || one >= least)) return triangles;
  const kept: number[] = [];
  for (let t = 0; t < triangles.length; t += 4)
    if (size[root(triangles[t + 1])] >= least) kept.push(3, triangles[t + 1], triangles[t + 2], triangles[t + 3]);
  return Uint32Array.from(kept);
}

self.onmessage = ({ data }: MessageEvent<SurfaceRequest>) => {
  const image = vtkImageData.newInstance();
  image.setDimensions(data.dims);
  image.getPointData().setScalars(vtkDataArray.newInstance({ values: data.values, numberOfComponents: 1 }));
  const cubes = vtkImageMarchingCubes.newInstance({ contourValue: data.level, computeNormals: true, mergePoints: true });
  cubes.setInputData(image);
  const made = cubes.getOutputData();
  const points = made.getPoints().getData() as Float32Array;
  const surface: Surface = {
    key: data.key,
    level: data.level,
    points,
    normals: made.getPointData().getNormals().getData() as Float32Array,
    triangles: large_parts(made.getPolys().getData() as Uint32Array, points.length / 3),
  };
  const buffers = [surface.points.buffer, surface.normals.buffer, surface.triangles.buffer] as ArrayBuffer[];
  (self as unknown as Worker).postMessage(surface, buffers);
};
