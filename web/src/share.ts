// A scene in an address: '#scene=' and its text, deflated, in base64url.

const longest_address = 8000; // [characters]. Longer: mail programs and chats cut it
const longest_text = 1 << 20; // [bytes] of an opened scene. More: a small address could fill the memory
const key = 'scene=';

/** Throws an Error of one line if the scene is too long. */
export async function address_of(text: string, page: string): Promise<string> {
  const packed = await through(new TextEncoder().encode(text), new CompressionStream('deflate-raw'), Infinity);
  const address = page.replace(/#.*$/, '') + '#' + key + base64url(packed);
  if (address.length > longest_address)
    throw new Error(`This scene makes an address of ${address.length} characters; at most ${longest_address} are safe to send.`);
  return address;
}

/** Text of the scene in a fragment; null without one. Throws an Error of one line if it is damaged. */
export async function scene_of(fragment: string): Promise<string | null> {
  const at = fragment.replace(/^#/, '');
  if (!at.startsWith(key)) return null;
  const damaged = new Error('The scene in this address is damaged; get the whole address again.');
  let bytes: Uint8Array<ArrayBuffer>;
  try {
    bytes = await through(from_base64url(at.slice(key.length)), new DecompressionStream('deflate-raw'), longest_text);
  } catch (problem) {
    throw problem instanceof TooLong ? new Error('The scene in this address is longer than a megabyte.') : damaged;
  }
  try {
    return new TextDecoder('utf-8', { fatal: true }).decode(bytes);
  } catch {
    throw damaged;
  }
}

class TooLong extends Error {}

async function through(
  bytes: Uint8Array<ArrayBuffer>, change: CompressionStream | DecompressionStream, most: number,
): Promise<Uint8Array<ArrayBuffer>> {
  const reader = new Blob([bytes]).stream().pipeThrough(change).getReader();
  const parts: Uint8Array[] = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    size += value.length;
    if (size > most) {
      await reader.cancel();
      throw new TooLong();
    }
    parts.push(value);
  }
  const all = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

function base64url(bytes: Uint8Array): string {
  let text = '';
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
}

function from_base64url(text: string): Uint8Array<ArrayBuffer> {
  const plain = atob(text.replace(/-/g, '+').replace(/_/g, '/'));
  return Uint8Array.from(plain, (letter) => letter.charCodeAt(0));
}
