// WASI's system calls for the module, with a file system in memory: no file of the machine can be reached.

const errno = { ok: 0, bad: 8, exists: 20, invalid: 28, is_directory: 31, missing: 44, not_directory: 54, not_empty: 55 };
const file_types = { directory: 3, regular: 4 };
const oflags = { create: 1, directory: 2, exclusive: 4, truncate: 8 };

class MemoryFile {
  bytes = new Uint8Array(0);
  length = 0;

  write(at: number, from: Uint8Array): void {
    const end = at + from.length;
    if (end > this.bytes.length) {
      const grown = new Uint8Array(Math.max(end, 2 * this.bytes.length, 4096));
      grown.set(this.bytes.subarray(0, this.length));
      this.bytes = grown;
    }
    this.bytes.set(from, at);
    this.length = Math.max(this.length, end);
  }
}

type Node = MemoryFile | Map<string, Node>;

interface Open {
  node: Node;
  at: number;
}

/** End of the module: an assertion of its own, or no memory. */
export class Exit extends Error {}

export class Wasi {
  private readonly root = new Map<string, Node>();
  private readonly open: (Open | undefined)[] = [];
  private memory: WebAssembly.Memory | undefined;
  /** Called with whole lines that the module prints. */
  print: (line: string) => void = () => undefined;
  private line = '';

  constructor() {
    this.open[3] = { node: this.root, at: 0 };
  }

  bind(memory: WebAssembly.Memory): void {
    this.memory = memory;
  }

  /** Removes a folder; returns its files. */
  take_folder(name: string): { name: string; bytes: Uint8Array }[] {
    const folder = this.root.get(name);
    this.root.delete(name);
    if (!(folder instanceof Map)) return [];
    return [...folder].flatMap(([file, node]) =>
      node instanceof MemoryFile ? [{ name: file, bytes: node.bytes.slice(0, node.length) }] : [],
    );
  }

  // ---- of the module ----

  private view(): DataView {
    return new DataView(this.memory!.buffer);
  }
  private bytes(at: number, length: number): Uint8Array {
    return new Uint8Array(this.memory!.buffer, at, length);
  }
  private parts(at: number, length: number): string[] {
    const path = new TextDecoder().decode(this.bytes(at, length).slice());
    return path.split('/').filter((part) => part !== '' && part !== '.');
  }
  /** Folder of a path and the last part of it; no folder: it is not there. */
  private parent(parts: string[]): [Map<string, Node> | undefined, string] {
    let folder: Node | undefined = this.root;
    for (const part of parts.slice(0, -1)) folder = folder instanceof Map ? folder.get(part) : undefined;
    return [folder instanceof Map ? folder : undefined, parts[parts.length - 1] ?? ''];
  }
  private find(parts: string[]): Node | undefined {
    if (parts.length === 0) return this.root;
    const [folder, name] = this.parent(parts);
    return folder?.get(name);
  }
  private put_stat(node: Node, to: number): void {
    const view = this.view();
    for (let i = 0; i < 64; i += 8) view.setBigUint64(to + i, 0n, true);
    view.setUint8(to + 16, node instanceof Map ? file_types.directory : file_types.regular);
    view.setBigUint64(to + 24, 1n, true);
    view.setBigUint64(to + 32, BigInt(node instanceof Map ? 0 : node.length), true);
  }
  private put_u32(at: number, value: number): number {
    this.view().setUint32(at, value, true);
    return errno.ok;
  }
  /** Spans of a list of buffers. */
  private *spans(list: number, count: number): Generator<Uint8Array> {
    for (let i = 0; i < count; ++i) {
      const view = this.view();
      yield this.bytes(view.getUint32(list + 8 * i, true), view.getUint32(list + 8 * i + 4, true));
    }
  }
  private printed(bytes: Uint8Array): void {
    this.line += new TextDecoder().decode(bytes.slice());
    const lines = this.line.split('\n');
    this.line = lines.pop() ?? '';
    for (const line of lines) this.print(line);
  }

  readonly imports = {
    environ_sizes_get: (count: number, bytes: number) => this.put_u32(count, 0) || this.put_u32(bytes, 0),
    environ_get: () => errno.ok,
    clock_time_get: (_clock: number, _precision: bigint, to: number) => {
      this.view().setBigUint64(to, BigInt(Math.round(performance.now() * 1e6)), true);
      return errno.ok;
    },
    proc_exit: (code: number) => {
      throw new Exit(`the module ended with ${code}`);
    },
    fd_prestat_get: (fd: number, to: number) => {
      if (fd !== 3) return errno.bad;
      return this.put_u32(to, 0) || this.put_u32(to + 4, 1);
    },
    fd_prestat_dir_name: (fd: number, to: number, length: number) => {
      if (fd !== 3 || length < 1) return errno.bad;
      this.bytes(to, 1)[0] = '/'.charCodeAt(0);
      return errno.ok;
    },
    fd_fdstat_get: (fd: number, to: number) => {
      const open = this.open[fd];
      const is_printer = fd === 1 || fd === 2;
      if (!open && !is_printer) return errno.bad;
      this.bytes(to, 24).fill(0);
      this.view().setUint8(to, open?.node instanceof Map ? file_types.directory : is_printer ? 2 : file_types.regular);
      this.view().setBigUint64(to + 8, ~0n, true);
      this.view().setBigUint64(to + 16, ~0n, true);
      return errno.ok;
    },
    fd_filestat_get: (fd: number, to: number) => {
      const open = this.open[fd];
      if (!open) return errno.bad;
      this.put_stat(open.node, to);
      return errno.ok;
    },
    fd_close: (fd: number) => {
      if (!this.open[fd] || fd === 3) return errno.bad;
      this.open[fd] = undefined;
      return errno.ok;
    },
    fd_seek: (fd: number, by: bigint, whence: number, to: number) => {
      const open = this.open[fd];
      if (!open || !(open.node instanceof MemoryFile)) return errno.bad;
      const from = whence === 0 ? 0 : whence === 1 ? open.at : open.node.length;
      const at = from + Number(by);
      if (at < 0) return errno.invalid;
      open.at = at;
      this.view().setBigUint64(to, BigInt(at), true);
      return errno.ok;
    },
    fd_pread: (fd: number, list: number, count: number, from: bigint, done: number) => {
      const open = this.open[fd];
      if (!open || !(open.node instanceof MemoryFile)) return errno.bad;
      let at = Number(from);
      for (const span of this.spans(list, count)) {
        const part = open.node.bytes.subarray(at, Math.min(at + span.length, open.node.length));
        span.set(part);
        at += part.length;
      }
      return this.put_u32(done, at - Number(from));
    },
    fd_write: (fd: number, list: number, count: number, done: number) => {
      const open = this.open[fd];
      let written = 0;
      for (const span of this.spans(list, count)) {
        if (fd === 1 || fd === 2) this.printed(span);
        else if (open && open.node instanceof MemoryFile) open.node.write(open.at + written, span);
        else return errno.bad;
        written += span.length;
      }
      if (open) open.at += written;
      return this.put_u32(done, written);
    },
    fd_readdir: (fd: number, to: number, room: number, cookie: bigint, done: number) => {
      const open = this.open[fd];
      if (!open || !(open.node instanceof Map)) return errno.bad;
      let used = 0;
      let next = 0n;
      for (const [name, node] of open.node) {
        ++next;
        if (next <= cookie) continue;
        const text = new TextEncoder().encode(name);
        const entry = new Uint8Array(24 + text.length);
        const view = new DataView(entry.buffer);
        view.setBigUint64(0, next, true);
        view.setUint32(16, text.length, true);
        view.setUint8(20, node instanceof Map ? file_types.directory : file_types.regular);
        entry.set(text, 24);
        const part = entry.subarray(0, room - used);
        this.bytes(to + used, part.length).set(part);
        used += part.length;
        if (used === room) break;
      }
      return this.put_u32(done, used);
    },
    path_create_directory: (_fd: number, at: number, length: number) => {
      const [folder, name] = this.parent(this.parts(at, length));
      if (!folder) return errno.missing;
      if (folder.has(name)) return errno.exists;
      folder.set(name, new Map());
      return errno.ok;
    },
    path_filestat_get: (_fd: number, _flags: number, at: number, length: number, to: number) => {
      const node = this.find(this.parts(at, length));
      if (!node) return errno.missing;
      this.put_stat(node, to);
      return errno.ok;
    },
    path_open: (
      _fd: number,
      _lookup: number,
      at: number,
      length: number,
      flags: number,
      _rights: bigint,
      _inherited: bigint,
      _fdflags: number,
      to: number,
    ) => {
      const parts = this.parts(at, length);
      let node = this.find(parts);
      if (node && flags & oflags.create && flags & oflags.exclusive) return errno.exists;
      if (node && flags & oflags.directory && !(node instanceof Map)) return errno.not_directory;
      if (!node) {
        const [folder, name] = this.parent(parts);
        if (!folder || !(flags & oflags.create)) return errno.missing;
        node = new MemoryFile();
        folder.set(name, node);
      }
      if (flags & oflags.truncate && node instanceof MemoryFile) node.length = 0;
      let fd = 4;
      while (this.open[fd]) ++fd;
      this.open[fd] = { node, at: 0 };
      return this.put_u32(to, fd);
    },
    path_remove_directory: (_fd: number, at: number, length: number) => {
      const [folder, name] = this.parent(this.parts(at, length));
      const node = folder?.get(name);
      if (!node) return errno.missing;
      if (!(node instanceof Map)) return errno.not_directory;
      if (node.size > 0) return errno.not_empty;
      folder!.delete(name);
      return errno.ok;
    },
    path_unlink_file: (_fd: number, at: number, length: number) => {
      const [folder, name] = this.parent(this.parts(at, length));
      const node = folder?.get(name);
      if (!node) return errno.missing;
      if (node instanceof Map) return errno.is_directory;
      folder!.delete(name);
      return errno.ok;
    },
  };
}
