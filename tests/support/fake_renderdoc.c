/* Stands for RenderDoc's library in a test: writes what it is asked for to a file, and makes a capture of one line. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char template[256] = "unnamed";
static char capture[300];
static uint32_t count;

static void note(const char *what) {
    FILE *log = fopen(getenv("FAKE_RENDERDOC_LOG"), "a");
    fprintf(log, "%s\n", what);
    fclose(log);
}

static void mask_overlay(uint32_t and_bits, uint32_t or_bits) { note(and_bits == 0 && or_bits == 0 ? "no overlay" : "overlay"); }
static void set_template(const char *path) { snprintf(template, sizeof template, "%s", path); }
static uint32_t num_captures(void) { return count; }
static uint32_t connected(void) { return 0; }

static uint32_t get_capture(uint32_t index, char *path, uint32_t *length, uint64_t *time) {
    if (index >= count) return 0;
    if (path) memcpy(path, capture, strlen(capture) + 1);
    if (length) *length = (uint32_t)strlen(capture) + 1;
    if (time) *time = 0;
    return 1;
}

static void start(void *device, void *window) { note("start"); }

static uint32_t end(void *device, void *window) {
    note("end");
    if (getenv("FAKE_RENDERDOC_FAILS")) return 0;
    snprintf(capture, sizeof capture, "%s_frame.rdc", template);
    FILE *file = fopen(capture, "w");
    fputs("a capture\n", file);
    fclose(file);
    ++count;
    return 1;
}

static void unused(void) { note("something else"); }

/* In the order of RENDERDOC_API_1_6_0. */
static void *api[] = {
    unused, unused, unused, unused, unused, unused, unused, unused, mask_overlay, unused, unused, set_template, unused,
    num_captures, get_capture, unused, connected, unused, unused, start, unused, end, unused, unused, unused, unused, unused,
};

int RENDERDOC_GetAPI(int version, void **out) {
    *out = api;
    return version <= 10600;
}
