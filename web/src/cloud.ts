// Volume rendering by vtk.js, loaded when it is first shown.

import '@kitware/vtk.js/Rendering/OpenGL/Profiles/Volume.js';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray.js';
import vtkPiecewiseFunction from '@kitware/vtk.js/Common/DataModel/PiecewiseFunction.js';
import vtkImageData from '@kitware/vtk.js/Common/DataModel/ImageData.js';
import vtkColorTransferFunction from '@kitware/vtk.js/Rendering/Core/ColorTransferFunction.js';
import vtkRenderWindowInteractor from '@kitware/vtk.js/Rendering/Core/RenderWindowInteractor.js';
import vtkVolume from '@kitware/vtk.js/Rendering/Core/Volume.js';
import vtkVolumeMapper from '@kitware/vtk.js/Rendering/Core/VolumeMapper.js';
import { magnitude_bytes } from './colors';
import { norm } from './geometry';
import type { Vec3 } from './protocol';
import type { SampledField } from './sampled_field';
import { by_column } from './view';

/** Cloud of a field between two values: clear at the lower, dense at the upper. */
export function cloud_of(field: SampledField, low: number, high: number, is_flow: boolean): vtkVolume {
  const m = field.index_to_hand;
  const spacing = [0, 1, 2].map((c) => norm([m[c], m[4 + c], m[8 + c]]) || 1e-6) as Vec3;
  const image = vtkImageData.newInstance({ spacing });
  image.setDimensions(field.dims);
  image.getPointData().setScalars(vtkDataArray.newInstance({ values: field.values, numberOfComponents: 1 }));
  const mapper = vtkVolumeMapper.newInstance({ sampleDistance: 0.7 * Math.min(...spacing), maximumSamplesPerRay: 1500 });
  mapper.setInputData(image);
  const volume = vtkVolume.newInstance();
  volume.setMapper(mapper);
  // The image has the lengths of the axes, the map their directions and the place.
  volume.setUserMatrix(by_column(m.map((x, n) => (n % 4 < 3 && n < 12 ? x / spacing[n % 4] : x))) as never);
  const colors = vtkColorTransferFunction.newInstance(), opacity = vtkPiecewiseFunction.newInstance();
  for (let n = 0; n <= 8; ++n) {
    const share = n / 8, value = low + share * (high - low);
    const grey = 0.35 + 0.6 * share;
    const [red, green, blue] = is_flow ? magnitude_bytes(share).map((c) => c / 255) : [grey, 0.95 * grey, 0.9 * grey];
    colors.addRGBPoint(value, red, green, blue);
    opacity.addPoint(value, 0.35 * share * share);
  }
  const property = volume.getProperty();
  property.setRGBTransferFunction(0, colors);
  property.setScalarOpacity(0, opacity);
  property.setScalarOpacityUnitDistance(0, 4 * Math.min(...spacing));
  property.setInterpolationTypeToLinear();
  property.setShade(!is_flow);
  property.setAmbient(0.3);
  property.setDiffuse(0.8);
  return volume;
}

/** Without events: the page has its own. */
export const new_interactor = (): vtkRenderWindowInteractor => vtkRenderWindowInteractor.newInstance();
