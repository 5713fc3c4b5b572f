import urls from 'virtual:penumbra-data';

/** The bytes of one of the page's files, which are compressed where their names end in .gz. */
export async function bytesOf(name: string): Promise<ArrayBuffer> {
    const response = await fetch(urls[name]);
    if (!response.ok) throw new Error(`${name}: ${response.status} ${response.statusText}`);
    const bytes = await response.arrayBuffer();
    // Some servers say that a .gz is encoded, and the browser has unpacked it already.
    const [first, second] = new Uint8Array(bytes);
    if (!name.endsWith('.gz') || first !== 0x1f || second !== 0x8b) return bytes;
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
}
