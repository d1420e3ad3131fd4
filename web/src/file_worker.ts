// Worker of files: ITK reads, here numbers become a GivenFile. A reader that fails ends with this Worker.

import { meta_facts, nifti_facts, no_facts, nrrd_facts, type HeaderFacts } from './headers';
import { read_image, read_series, read_tags, type ItkFile, type ItkImage } from './itk';
import type { GivenField, GivenFile, Vec3 } from './protocol';

export interface FileRequest {
  format: 'nrrd' | 'nifti' | 'metaimage' | 'dicom';
  name: string; // as a scene names it
  files: { name: string; bytes: ArrayBuffer }[]; // the named one first
}

export type FileAnswer = { file: GivenFile; notes: string[] } | { problem: string };

export const most_bytes = 512 * 1024 * 1024; // of a grid's voxels. More: a tab of a usual machine has no memory for it
const metres: Record<string, number> = { m: 1, mm: 1e-3, um: 1e-6, cm: 1e-2 };

self.onmessage = async ({ data }: MessageEvent<FileRequest>) => {
  const post = (self as unknown as Worker).postMessage.bind(self) as (answer: FileAnswer, buffers?: Transferable[]) => void;
  try {
    const answer = await read(data);
    post(answer, answer.file.fields.map((field) => field.voxels));
  } catch (problem) {
    const words = problem instanceof Error ? problem.message : 'cannot be read; check that it is whole';
    post({ problem: words.split('\n')[0].slice(0, 300) });
  }
};

async function read(request: FileRequest): Promise<{ file: GivenFile; notes: string[] }> {
  const notes: string[] = [];
  const is_dicom = request.format === 'dicom';
  // Files of several folders may have equal names.
  const path_of = (name: string, n: number) => (is_dicom ? String(n) : name);
  const given = request.files.map(({ name, bytes }, n) => ({ name, path: path_of(name, n), data: new Uint8Array(bytes) }));
  const files = is_dicom ? await largest_series(given, notes) : given;
  const sources = await Promise.all(files.map(source_of));
  const facts = is_dicom ? await dicom_facts(files) : await facts_of(request.format, files[0].data);
  if (facts.claimed_bytes > most_bytes)
    throw new Error(`has ${Math.round(facts.claimed_bytes / 1e6)} MB of voxels; at most ${most_bytes / (1 << 20)} MB can be felt ` +
      'in a browser: crop or resample it');
  const { image, order } = await image_of(request.format, files);
  sources.sort((a, b) => order.indexOf(a.path) - order.indexOf(b.path));
  if (facts.frames > 1 && !facts.vector) notes.push(`${request.name}: has ${facts.frames} frames; the first one is felt`);
  const is_unit_known = facts.length_unit in metres;
  if (facts.length_unit !== '' && !is_unit_known) throw new Error(`has lengths in '${facts.length_unit}'; mm, cm, um and m are known`);
  const file: GivenFile = {
    name: request.name,
    format: request.format,
    modality: facts.modality,
    length_unit: facts.length_unit || 'mm',
    length_unit_assumed: !is_unit_known,
    medical_frame: facts.medical_frame,
    bytes: sources.reduce((sum, one) => sum + one.bytes, 0),
    sha256: sources[0].sha256,
    sources: sources.map(({ name, bytes, sha256 }) => ({ name, bytes, sha256 })),
    fields: [field_of(image, facts, metres[facts.length_unit || 'mm'])],
  };
  return { file, notes };
}

interface NamedFile extends ItkFile {
  name: string;
}

type Source = GivenFile['sources'][number] & { path: string };

async function source_of({ name, path, data }: NamedFile): Promise<Source> {
  return { name, path, bytes: data.length, sha256: await sha256_of(data) };
}

/** The series with the most slices of all that were given. */
async function largest_series(files: NamedFile[], notes: string[]): Promise<NamedFile[]> {
  const series = new Map<string, NamedFile[]>();
  for (const file of files) {
    const uid = (await read_tags(file, ['0020|000e'])).get('0020|000e') ?? '';
    series.set(uid, [...(series.get(uid) ?? []), file]);
  }
  const largest = [...series.values()].reduce((most, one) => (one.length > most.length ? one : most));
  if (series.size > 1) notes.push(`These are ${series.size} series; the one with the most slices, ${largest.length}, is felt`);
  return largest;
}

/** Hexadecimal; '' where the browser has none. */
async function sha256_of(bytes: Uint8Array): Promise<string> {
  if (!self.crypto?.subtle) return '';
  const sum = new Uint8Array(await crypto.subtle.digest('SHA-256', bytes as Uint8Array<ArrayBuffer>));
  return [...sum].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

async function facts_of(format: FileRequest['format'], bytes: Uint8Array): Promise<HeaderFacts> {
  if (format === 'nrrd') return nrrd_facts(bytes);
  if (format === 'metaimage') return meta_facts(bytes);
  return nifti_facts(await beginning(bytes, 540));
}

/** First bytes of a file, decompressed if it is packed by gzip. */
async function beginning(bytes: Uint8Array, count: number): Promise<Uint8Array> {
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes.subarray(0, count);
  const reader = new Blob([bytes as Uint8Array<ArrayBuffer>]).stream().pipeThrough(new DecompressionStream('gzip')).getReader();
  const start = new Uint8Array(count);
  let at = 0;
  while (at < count) {
    const { done, value } = await reader.read();
    if (done) break;
    start.set(value.subarray(0, count - at), at);
    at += value.length;
  }
  await reader.cancel();
  return start.subarray(0, Math.min(at, count));
}

async function dicom_facts(files: ItkFile[]): Promise<HeaderFacts> {
  const facts = no_facts();
  const tags = await read_tags(files[0], ['0008|0060', '0028|1052', '0028|1053', '0028|0103', '0028|0100']);
  const number = (tag: string, otherwise: number) => {
    const value = parseFloat(tags.get(tag) ?? '');
    return Number.isFinite(value) ? value : otherwise;
  };
  facts.modality = tags.get('0008|0060') ?? '';
  facts.value_unit = facts.modality === 'CT' ? 'HU' : '';
  facts.length_unit = 'mm';
  facts.medical_frame = true;
  facts.slope = number('0028|1053', 1);
  facts.intercept = number('0028|1052', 0);
  facts.is_rescaled_by_itk = facts.slope !== 1 || facts.intercept !== 0;
  const bits = number('0028|0100', 16);
  facts.stored = (number('0028|0103', 0) === 0 ? 'uint' : 'int') + bits;
  facts.claimed_bytes = files.reduce((sum, file) => sum + file.data.length, 0);
  return facts;
}

/** Image, and the paths of its files in the order of the slices. */
async function image_of(format: FileRequest['format'], files: ItkFile[]): Promise<{ image: ItkImage; order: string[] }> {
  if (format === 'dicom') return read_series(files);
  const reader = { nrrd: 'nrrd-read-image', nifti: 'nifti-read-image', metaimage: 'meta-read-image' }[format];
  return { image: await read_image(reader, files), order: files.map((file) => file.path) };
}

const types = {
  uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, int32: Int32Array, float32: Float32Array, float64: Float64Array,
};
type StoredType = keyof typeof types;

/** Type that holds all numbers of another exactly, or, of 64 bits, nearly. */
function kept_type(type: string): StoredType {
  if (type in types) return type as StoredType;
  return type === 'int8' ? 'int16' : 'float64';
}

function field_of(image: ItkImage, facts: HeaderFacts, metres_per_unit: number): GivenField {
  const { dimension, components, componentType } = image.imageType;
  const is_vector_of_frames = facts.vector && components === 1 && image.size[3] === 3;
  if (components !== 1 && components !== 3)
    throw new Error(`has ${components} numbers per voxel; one, or a vector of three, can be felt`);
  const dims = [0, 1, 2].map((n) => (n < dimension ? image.size[n] : 1)) as Vec3;
  const axes = [0, 1, 2].map((n) => axis_of(image, n, metres_per_unit)) as [Vec3, Vec3, Vec3];
  const origin_m = [0, 1, 2].map((n) => (image.origin[n] ?? 0) * metres_per_unit) as Vec3;
  const count = dims[0] * dims[1] * dims[2];
  // ITK answers values; numbers as stored need less memory, and are what a native reader has.
  const is_restored = facts.is_rescaled_by_itk && /^u?int(8|16)$/.test(facts.stored) && components === 1 && !is_vector_of_frames;
  const type = kept_type(is_restored ? facts.stored : componentType);
  const is_scaled_here = is_restored || !facts.is_rescaled_by_itk;
  const voxels = new types[type](count * (is_vector_of_frames ? 3 : components));
  for (let n = 0; n < voxels.length; ++n) {
    const from = is_vector_of_frames ? Math.floor(n / 3) + count * (n % 3) : n;
    const value = Number(image.data[from]);
    voxels[n] = is_restored ? Math.round((value - facts.intercept) / facts.slope) : value;
  }
  return {
    name: is_vector_of_frames || components === 3 ? 'vector' : 'value',
    unit: facts.value_unit,
    type,
    components: is_vector_of_frames ? 3 : components,
    dims,
    origin_m,
    axes_m: axes,
    slope: is_scaled_here ? facts.slope : 1,
    intercept: is_scaled_here ? facts.intercept : 0,
    voxels: voxels.buffer,
  };
}

/** Step along a grid axis; an axis that the image lacks is as long as the first and across the others. */
function axis_of(image: ItkImage, axis: number, metres_per_unit: number): Vec3 {
  const d = image.imageType.dimension;
  const length = (image.spacing[axis] ?? image.spacing[0]) * metres_per_unit;
  if (axis >= d) return [0, 1, 2].map((n) => (n === axis ? length : 0)) as Vec3;
  return [0, 1, 2].map((row) => (row < d ? length * image.direction[d * row + axis] : 0)) as Vec3;
}
