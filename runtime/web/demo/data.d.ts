/** Where the page's files are, by their names (vite.config.mjs). */
declare module 'virtual:penumbra-data' {
    const urls: Record<string, string>;
    export default urls;
}
