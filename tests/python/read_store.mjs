// Prints shape, type and SHA-256 of each octave of a store, read by zarrita: node read_store.mjs STORE PATH…
import { createHash } from "node:crypto";
import * as zarr from "zarrita";
import FileSystemStore from "@zarrita/storage/fs";

const [store, ...paths] = process.argv.slice(2);
const root = zarr.root(new FileSystemStore(store));
for (const path of paths) {
  const array = await zarr.open(root.resolve(path), { kind: "array" });
  const { data, shape } = await zarr.get(array);
  const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
  console.log(path, array.dtype, shape.join("x"), createHash("sha256").update(bytes).digest("hex"));
}
