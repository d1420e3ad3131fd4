// Modules of vtk.js without declarations of their own.

declare module '@kitware/vtk.js/Filters/General/ImageMarchingCubes.js' {
  import type vtkImageData from '@kitware/vtk.js/Common/DataModel/ImageData.js';
  import type vtkPolyData from '@kitware/vtk.js/Common/DataModel/PolyData.js';

  interface ImageMarchingCubes {
    setInputData(image: vtkImageData): void;
    getOutputData(): vtkPolyData;
  }
  const module: {
    newInstance(values: { contourValue: number; computeNormals: boolean; mergePoints: boolean }): ImageMarchingCubes;
  };
  export default module;
}

declare module '@kitware/vtk.js/Rendering/OpenGL/Profiles/Geometry.js';
declare module '@kitware/vtk.js/Rendering/OpenGL/Profiles/Volume.js';
