// Facts of a header that ITK's readers leave out: unit, frame, modality, stored type, rescaling. Headers are read here for
// these words alone; geometry and voxels come from ITK.

export interface HeaderFacts {
  length_unit: string;
  medical_frame: boolean;
  modality: string;
  value_unit: string;
  /** Stored type of a voxel, '' unknown, and the map from stored numbers to values, if ITK applies it. */
  stored: string;
  slope: number;
  intercept: number;
  is_rescaled_by_itk: boolean;
  /** Bytes of the voxels that the header claims. */
  claimed_bytes: number;
  frames: number;
  vector: boolean;
  /** Names of its data files; empty: within itself. */
  data_files: string[];
}

export function no_facts(): HeaderFacts {
  return {
    length_unit: '', medical_frame: false, modality: '', value_unit: '', stored: '', slope: 1, intercept: 0,
    is_rescaled_by_itk: false, claimed_bytes: 0, frames: 1, vector: false, data_files: [],
  };
}

const scanners = ['CT', 'MR', 'PT', 'NM', 'US'];

/** Lines of a text header, up to where binary voxels begin. */
function header_lines(bytes: Uint8Array, ends: (line: string) => boolean): string[] {
  const lines: string[] = [];
  const text = new TextDecoder('latin1').decode(bytes.subarray(0, 1 << 16));
  for (const line of text.split('\n')) {
    lines.push(line.replace(/\r$/, ''));
    if (ends(lines[lines.length - 1])) break;
  }
  return lines;
}

const numbers = (words: string): number[] => words.trim().split(/\s+/).map(Number);
const product = (factors: number[]): number => factors.reduce((all, one) => all * one, 1);

const nrrd_bytes: Record<string, number> = {
  char: 1, short: 2, int: 4, float: 4, double: 8, long: 8, longlong: 8, int8: 1, int16: 2, int32: 4, int64: 8,
};

/** Bytes of a voxel of a NRRD type: 'unsigned short', 'uint16', 'ushort', 'uint16_t' … */
function bytes_of_nrrd_type(type: string): number {
  const name = type.toLowerCase().replace(/unsigned|signed|_t$|\s/g, '').replace(/^u(?=char|short|int|long)/, '');
  return nrrd_bytes[name] ?? 8;
}

export function nrrd_facts(bytes: Uint8Array): HeaderFacts {
  const facts = no_facts();
  const lines = header_lines(bytes, (line) => line === '');
  if (!lines[0]?.startsWith('NRRD')) throw new Error('is no NRRD file: it does not begin with NRRD');
  const fields = new Map<string, string>();
  for (const line of lines.slice(1)) {
    if (line.startsWith('#')) continue;
    const key_value = line.match(/^([^:]+):=(.*)$/), field = line.match(/^([^:]+): ?(.*)$/);
    if (key_value) fields.set('=' + key_value[1].trim(), key_value[2].trim());
    else if (field) fields.set(field[1].trim().toLowerCase(), field[2].trim());
  }
  const space = (fields.get('space') ?? '').toLowerCase();
  facts.medical_frame = /^(right|left)-(anterior|posterior)-superior(-time)?$|^(ras|las|lps)t?$/.test(space);
  const unit = (fields.get('space units') ?? fields.get('units') ?? '').match(/"([^"]*)"/g)?.map((u) => u.slice(1, -1)) ?? [];
  facts.length_unit = unit.find((one) => one.trim() !== '')?.trim() ?? '';
  facts.value_unit = (fields.get('sample units') ?? '').replace(/"/g, '').trim();
  const modality = ['=modality', '=Modality', '=DICOM_0008_0060'].map((k) => fields.get(k) ?? '').find((m) => scanners.includes(m));
  facts.modality = modality ?? '';
  const kinds = (fields.get('kinds') ?? '').toLowerCase().split(/\s+/);
  facts.vector = kinds.some((kind) => /^(3-|covariant-)?(vector|normal|gradient)$/.test(kind));
  const directions = (fields.get('space directions') ?? '').match(/none|\([^)]*\)/g) ?? [];
  const sizes = numbers(fields.get('sizes') ?? '');
  facts.claimed_bytes = product(sizes) * bytes_of_nrrd_type(fields.get('type') ?? '');
  // An axis beside three of space, and beside the vector's, counts frames.
  const others = sizes.filter((_, n) => directions[n] === 'none' && !/vector|normal|gradient/.test(kinds[n] ?? ''));
  facts.frames = others.length > 0 ? product(others) : sizes.length > 3 && !facts.vector ? sizes[sizes.length - 1] : 1;
  facts.data_files = data_files_of_nrrd(fields.get('data file') ?? fields.get('datafile') ?? '', lines);
  return facts;
}

function data_files_of_nrrd(words: string, lines: string[]): string[] {
  if (words === '') return [];
  if (!/^LIST/.test(words)) return [words];
  const at = lines.findIndex((line) => /^data ?file:/i.test(line));
  return lines.slice(at + 1).filter((line) => line !== '');
}

const meta_bytes: Record<string, number> = {
  CHAR: 1, UCHAR: 1, SHORT: 2, USHORT: 2, INT: 4, UINT: 4, FLOAT: 4, DOUBLE: 8, LONG: 8, ULONG: 8, LONG_LONG: 8, ULONG_LONG: 8,
};

export function meta_facts(bytes: Uint8Array): HeaderFacts {
  const facts = no_facts();
  const lines = header_lines(bytes, (line) => /^\s*ElementDataFile\s*=/.test(line) && !/=\s*LIST/.test(line));
  const fields = new Map<string, string>();
  for (const line of lines) {
    const field = line.match(/^\s*(\w+)\s*[=:]\s*(.*?)\s*$/);
    if (field) fields.set(field[1], field[2]);
  }
  if (!fields.has('ElementDataFile')) throw new Error('is no MetaImage header: it has no ElementDataFile');
  const letters = fields.get('AnatomicalOrientation') ?? '';
  const sizes = numbers(fields.get('DimSize') ?? '');
  facts.medical_frame = /^[RLAPSI]{3}/.test(letters) && sizes.length === 3;
  const units = (fields.get('DistanceUnits') ?? '').split(/\s+/);
  facts.length_unit = units.every((unit) => unit === units[0]) ? units[0] : units.join(' ');
  facts.modality = scanners.find((one) => fields.get('Modality') === 'MET_MOD_' + one) ?? '';
  facts.slope = Number(fields.get('ElementToIntensityFunctionSlope') ?? 1);
  facts.intercept = Number(fields.get('ElementToIntensityFunctionOffset') ?? 0);
  facts.vector = fields.get('ElementNumberOfChannels') === '3';
  const type = (fields.get('ElementType') ?? '').replace(/^MET_/, '').replace(/_ARRAY$/, '');
  facts.claimed_bytes = product(sizes) * (meta_bytes[type] ?? 8) * Number(fields.get('ElementNumberOfChannels') ?? 1);
  facts.frames = sizes[3] ?? 1;
  const file = fields.get('ElementDataFile')!;
  if (/^LIST/i.test(file)) facts.data_files = lines.slice(lines.findIndex((line) => /ElementDataFile/.test(line)) + 1).filter(Boolean);
  else if (!/^LOCAL$/i.test(file)) facts.data_files = [file];
  return facts;
}

const nifti_types: Record<number, [string, number]> = {
  2: ['uint8', 1], 4: ['int16', 2], 8: ['int32', 4], 16: ['float32', 4], 64: ['float64', 8], 256: ['int8', 1],
  512: ['uint16', 2], 768: ['uint32', 4], 1024: ['int64', 8], 1280: ['uint64', 8],
};
const colors_of_nifti = [128, 2304], complex_of_nifti = [32, 1792];

/** \param bytes  of the header, decompressed */
export function nifti_facts(bytes: Uint8Array): HeaderFacts {
  const facts = no_facts();
  if (bytes.length < 348) throw new Error('is shorter than a NIfTI header; get the whole file');
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const little = view.getInt32(0, true) < 1000;
  const header_bytes = view.getInt32(0, little);
  if (header_bytes === 540) throw new Error('is NIfTI-2, which the reader here does not know; write it as NIfTI-1');
  if (header_bytes !== 348) throw new Error('is no NIfTI file: its header has another length');
  const dim = (n: number) => view.getInt16(40 + 2 * n, little);
  const type = view.getInt16(70, little);
  if (colors_of_nifti.includes(type))
    throw new Error('holds colours (RGB), which have no one value to feel; export the values that they were made from');
  if (complex_of_nifti.includes(type)) throw new Error('holds complex numbers; export magnitude or phase');
  const [stored, voxel_bytes] = nifti_types[type] ?? ['', 8];
  facts.stored = stored;
  const sizes = Array.from({ length: Math.min(7, Math.max(0, dim(0))) }, (_, n) => dim(n + 1));
  facts.claimed_bytes = product(sizes) * voxel_bytes;
  facts.frames = sizes[3] ?? 1;
  const intent = view.getInt16(68, little);
  facts.vector = (intent === 1007 || intent === 1006) && (sizes[4] === 3 || (sizes.length === 4 && sizes[3] === 3));
  const slope = view.getFloat32(112, little), intercept = view.getFloat32(116, little);
  if (Number.isFinite(slope) && slope !== 0) {
    facts.slope = slope;
    facts.intercept = Number.isFinite(intercept) ? intercept : 0;
    facts.is_rescaled_by_itk = slope !== 1 || facts.intercept !== 0;
  }
  facts.medical_frame = view.getInt16(252, little) > 0 || view.getInt16(254, little) > 0;
  facts.length_unit = ['', 'm', 'mm', 'um'][view.getUint8(123) & 7] ?? '';
  return facts;
}
