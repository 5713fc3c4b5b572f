import urls from 'virtual:penumbra-data';

/** The bytes of one of the page's files, which are compressed where their names end in .gz. */
export async function bytesOf(name: string): Promise<ArrayBuffer> {
    const response = await fetch(urls[name]);
    if (!response.ok) throw new Error(`${name}: ${response.status} ${response.statusText}`);
    if (!name.endsWith('.gz')) return response.arrayBuffer();
    return new Response(response.body!.pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
}
