// ITK's readers (itk-wasm), run in the Worker of files. They are loaded from the page's own folder when a file is opened.

// The package's entry loads its modules by blob and data addresses, which the page's policy refuses; its runner does not.
import bare_run from '../node_modules/itk-wasm/dist/pipeline/internal/run-pipeline-emscripten.js';

/** Types of itk-wasm's interface. */
const json = 'JsonCompatible', image = 'Image', binary_file = 'BinaryFile';

export interface ItkFile {
  path: string;
  data: Uint8Array;
}

export interface ItkImage {
  imageType: { dimension: number; componentType: string; pixelType: string; components: number };
  origin: number[];
  spacing: number[];
  direction: ArrayLike<number>; // by row, of dimension × dimension
  size: number[];
  data: ArrayLike<number> & { buffer: ArrayBuffer; byteOffset: number; byteLength: number };
}

interface Result {
  returnValue: number;
  stderr: string;
  outputs: { data: unknown }[];
}

type Module = Record<string, unknown>;
type Run = (module: Module, args: string[], outputs: object[], inputs: object[]) => Result;
const run = bare_run as unknown as Run;

const loaded = new Map<string, Promise<Module>>();

/** \param reader  name of a module of the folder 'readers' */
function load(reader: string): Promise<Module> {
  const module = loaded.get(reader) ?? fetched(reader);
  loaded.set(reader, module);
  return module;
}

async function fetched(reader: string): Promise<Module> {
  const folder = new URL('readers/', self.location.href);
  const [answer, script] = await Promise.all([
    fetch(new URL(`${reader}.wasm`, folder)),
    import(/* @vite-ignore */ new URL(`${reader}.js`, folder).href) as Promise<{
      default: (options: object) => Promise<Module>;
    }>,
  ]);
  if (!answer.ok) throw new Error(`the page's folder lacks readers/${reader}.wasm`);
  return script.default({ wasmBinary: await answer.arrayBuffer() });
}

/** Reads an image of one of ITK's formats. \param files  the first is opened */
export async function read_image(reader: string, files: ItkFile[]): Promise<ItkImage> {
  const module = await load(reader);
  const inputs = files.map((file) => ({ type: binary_file, data: file }));
  const result = run(module, [files[0].path, '0', '1', '--memory-io'], [{ type: json }, { type: image }], inputs);
  const could_read = result.outputs[0]?.data;
  if (result.returnValue !== 0 || could_read === false) throw new Error(cause_of(result.stderr));
  return result.outputs[1].data as ItkImage;
}

/** Reads the first series of DICOM files; answers its files in the order of the slices, too. */
export async function read_series(files: ItkFile[]): Promise<{ image: ItkImage; order: string[] }> {
  const module = await load('read-image-dicom-file-series');
  const inputs = files.map((file) => ({ type: binary_file, data: file }));
  const args = ['0', '1', '--memory-io', '--input-images', ...files.map((file) => file.path)];
  const result = run(module, args, [{ type: image }, { type: json }], inputs);
  if (result.returnValue !== 0) throw new Error(cause_of(result.stderr));
  return { image: result.outputs[0].data as ItkImage, order: result.outputs[1].data as string[] };
}

/** Some tags of a DICOM file, by 'gggg|eeee'. */
export async function read_tags(file: ItkFile, tags: string[]): Promise<Map<string, string>> {
  const module = await load('read-dicom-tags');
  const inputs = [{ type: binary_file, data: file }, { type: json, data: { tags } }];
  const result = run(module, [file.path, '0', '--memory-io', '--tags-to-read', '1'], [{ type: json }], inputs);
  if (result.returnValue !== 0) throw new Error(cause_of(result.stderr));
  return new Map((result.outputs[0].data as [string, string][]).map(([tag, value]) => [tag, value.trim()]));
}

/** Last line of a library's complaint, without its places in the source. */
function cause_of(complaint: string): string {
  const lines = complaint.split('\n').map((line) => line.replace(/^.*?(Error|ERROR):/i, '').trim()).filter(Boolean);
  const last = lines.length > 0 ? lines[lines.length - 1].slice(0, 160) : '';
  return last ? `cannot be read (${last})` : 'cannot be read; check that it is whole';
}
