// For scripts/dev/sanitizer_cases: a program that is built with -fsanitize-coverage=trace-pc-guard and linked with this
// appends a line for every edge that it ran, when it ends: the file of its code and the address in it. They go to a new
// file in the folder $PENUMBRA_EDGES.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static uintptr_t* ran;  // where the code of an edge returns to; 0: it did not run
static uint32_t edges, room;

static void write_edges(void) {
    const char* folder = getenv("PENUMBRA_EDGES");
    char path[4096];
    if (!folder) return;
    snprintf(path, sizeof path, "%s/%d.edges", folder, (int)getpid());
    FILE* file = fopen(path, "w");
    if (!file) return;
    char program[4096] = "";
    if (readlink("/proc/self/exe", program, sizeof program - 1) < 0) program[0] = 0;
    for (uint32_t i = 0; i < room; ++i) {
        Dl_info of;
        if (!ran[i] || !dladdr((void*)ran[i], &of)) continue;
        const char* code = strstr(of.dli_fname, ".so") ? of.dli_fname : program;
        fprintf(file, "%s %lx\n", code, (unsigned long)(ran[i] - (uintptr_t)of.dli_fbase - 1));
    }
    fclose(file);
}

// Called for every file of code before main(), with a place for a number of each of its edges.
void __sanitizer_cov_trace_pc_guard_init(uint32_t* first, uint32_t* last) {
    if (first == last || *first) return;
    if (edges == 0) atexit(write_edges);
    for (uint32_t* edge = first; edge < last; ++edge) *edge = ++edges;
    ran = realloc(ran, (edges + 1) * sizeof *ran);
    if (!ran) abort();
    memset(ran + room, 0, (edges + 1 - room) * sizeof *ran);
    room = edges + 1;
}

void __sanitizer_cov_trace_pc_guard(uint32_t* edge) {
    if (*edge < room && !ran[*edge]) ran[*edge] = (uintptr_t)__builtin_return_address(0);
}
