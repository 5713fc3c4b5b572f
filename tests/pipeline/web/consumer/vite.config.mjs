export default {
    base: './',
    logLevel: 'warn',
    worker: { format: 'es' },
    build: {
        target: 'es2022',
        modulePreload: false,
        chunkSizeWarningLimit: 20000,
        rollupOptions: { input: { main: new URL('index.html', import.meta.url).pathname, unused: new URL('unused.ts', import.meta.url).pathname } },
    },
};
