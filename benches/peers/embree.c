// Embree on the faces and rays that `rayloom bench accel --against embree` wrote, one thread. Built and run by embree.py beside it.
//
//   embree FOLDER [robust]     then commands on standard input, an answer each:
//   build                      "built CPU_SECONDS BYTES"
//   trace KIND WIDTH           WIDTH rays at a time (1, 8, 16), until 0.2 s are over: "traced RAYS CPU_SECONDS"
//   depths KIND WIDTH          depths to FOLDER/KIND.depths: "written RAYS"
// Files hold 32-bit floats: FOLDER/faces nine a triangle, FOLDER/KIND seven a ray (origin, direction, far end). KIND "shadow" asks for any
// hit (depth 0), others for the nearest; infinity is a miss.
//
// Declared here as Embree 4 documents it, so that no header is needed: the Python package `embreex` brings the library alone.
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>
#include <xmmintrin.h>

typedef struct Device* Device;
typedef struct Scene* Scene;
typedef struct Geometry* Geometry;
enum { TRIANGLES = 0, INDICES = 0, VERTICES = 1, UINT3 = 0x5003, FLOAT3 = 0x9003, ROBUST = 1 << 2, COHERENT = 1 << 16, INVALID = -1 };
Device rtcNewDevice(const char*);
void rtcSetDeviceMemoryMonitorFunction(Device, bool (*)(void*, ssize_t, bool), void*);
Scene rtcNewScene(Device);
void rtcSetSceneFlags(Scene, int);
Geometry rtcNewGeometry(Device, int);
void rtcSetSharedGeometryBuffer(Geometry, int, unsigned, int, const void*, size_t, size_t, size_t);
void rtcCommitGeometry(Geometry);
unsigned rtcAttachGeometry(Scene, Geometry);
void rtcCommitScene(Scene);

// Rays side by side; hits begin right behind, and may be longer than is known here.
#define RAYS(N) struct { _Alignas(64) float ox[N]; float oy[N], oz[N], near[N], dx[N], dy[N], dz[N], time[N], far[N]; \
    unsigned mask[N], id[N], flags[N]; float nx[N], ny[N], nz[N], u[N], v[N]; unsigned prim[N], geom[N], inst[N], spare[8 * N]; }
typedef RAYS(1) Rays1;
typedef RAYS(8) Rays8;
typedef RAYS(16) Rays16;
typedef struct { int flags; unsigned features; void* rest[8]; } Arguments;
void rtcIntersect1(Scene, void*, Arguments*);
void rtcOccluded1(Scene, void*, Arguments*);
void rtcIntersect8(const int*, Scene, void*, Arguments*);
void rtcOccluded8(const int*, Scene, void*, Arguments*);
void rtcIntersect16(const int*, Scene, void*, Arguments*);
void rtcOccluded16(const int*, Scene, void*, Arguments*);

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static ssize_t bytes_now = 0;
static bool count_bytes(void* user, ssize_t bytes, bool post) {
    (void)user, (void)post;
    bytes_now += bytes;
    return true;
}

static float* read_floats(const char* folder, const char* name, size_t* n) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE* f = fopen(path, "rb");
    if (!f) { perror(path); exit(1); }
    fseek(f, 0, SEEK_END);
    *n = ftell(f) / 4;
    rewind(f);
    float* out = malloc(*n * 4 + 64);
    if (fread(out, 4, *n, f) != *n) exit(1);
    fclose(f);
    return out;
}

static Scene scene;
// Coherent rays where the caller knows of it: Embree picks its packet code by that.
static Arguments together = { COHERENT, 0xffffffff, {0} }, alone = { 0, 0xffffffff, {0} };

#define TRACE(N, CALL, ANY)                                                                                     \
    static void trace##N##_##ANY(const float* r, size_t n, float* depths, Arguments* how) {                     \
        Rays##N p;                                                                                              \
        int valid[N];                                                                                           \
        for (size_t at = 0; at < n; at += N) {                                                                  \
            for (int k = 0; k < N; k++) {                                                                       \
                const float* v = r + 7 * (at + k < n ? at + k : n - 1);                                         \
                valid[k] = at + k < n ? -1 : 0;                                                                 \
                p.ox[k] = v[0], p.oy[k] = v[1], p.oz[k] = v[2], p.dx[k] = v[3], p.dy[k] = v[4], p.dz[k] = v[5]; \
                p.near[k] = 0, p.time[k] = 0, p.far[k] = v[6];                                                  \
                p.mask[k] = -1, p.id[k] = 0, p.flags[k] = 0, p.geom[k] = p.inst[k] = INVALID;                   \
            }                                                                                                   \
            CALL;                                                                                               \
            if (depths)                                                                                         \
                for (int k = 0; k < N && at + k < n; k++)                                                       \
                    depths[at + k] = ANY ? (p.far[k] < 0 ? 0 : INFINITY) : p.geom[k] == (unsigned)INVALID ? INFINITY : p.far[k]; \
            (void)valid;                                                                                        \
        }                                                                                                       \
    }
TRACE(1, rtcIntersect1(scene, &p, how), 0)
TRACE(1, rtcOccluded1(scene, &p, how), 1)
TRACE(8, rtcIntersect8(valid, scene, &p, how), 0)
TRACE(8, rtcOccluded8(valid, scene, &p, how), 1)
TRACE(16, rtcIntersect16(valid, scene, &p, how), 0)
TRACE(16, rtcOccluded16(valid, scene, &p, how), 1)

static void trace(int width, bool any, bool coherent, const float* r, size_t n, float* depths) {
    Arguments* how = coherent ? &together : &alone;
    if (width == 1) (any ? trace1_1 : trace1_0)(r, n, depths, &alone);
    else if (width == 8) (any ? trace8_1 : trace8_0)(r, n, depths, how);
    else (any ? trace16_1 : trace16_0)(r, n, depths, how);
}

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    // As Embree's documentation asks for.
    _mm_setcsr(_mm_getcsr() | 0x8040);
    size_t n_floats;
    float* faces = read_floats(argv[1], "faces", &n_floats);
    unsigned* indices = malloc(n_floats / 3 * 4 + 64);
    for (size_t k = 0; k < n_floats / 3; k++) indices[k] = k;
    Device device = rtcNewDevice("threads=1");
    if (!device) { fprintf(stderr, "no device\n"); return 1; }
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, NULL);
    char command[16], kind[64], loaded[64] = "";
    float* rays = NULL;
    size_t n = 0;
    int width;
    while (scanf("%15s", command) == 1) {
        if (!strcmp(command, "build")) {
            double start = seconds();
            scene = rtcNewScene(device);
            if (argc > 2) rtcSetSceneFlags(scene, ROBUST);
            Geometry mesh = rtcNewGeometry(device, TRIANGLES);
            rtcSetSharedGeometryBuffer(mesh, VERTICES, 0, FLOAT3, faces, 0, 12, n_floats / 3);
            rtcSetSharedGeometryBuffer(mesh, INDICES, 0, UINT3, indices, 0, 12, n_floats / 9);
            rtcCommitGeometry(mesh);
            rtcAttachGeometry(scene, mesh);
            rtcCommitScene(scene);
            printf("built %.6f %zd\n", seconds() - start, bytes_now);
        } else if (scanf("%63s %d", kind, &width) == 2) {
            if (strcmp(kind, loaded)) {
                free(rays);
                rays = read_floats(argv[1], kind, &n);
                n /= 7;
                strcpy(loaded, kind);
            }
            bool any = !strcmp(kind, "shadow"), coherent = !strcmp(kind, "primary") || any;
            if (!strcmp(command, "trace")) {
                size_t done = 0;
                double start = seconds(), took = 0;
                while (took < 0.2) {
                    trace(width, any, coherent, rays, n, NULL);
                    done += n;
                    took = seconds() - start;
                }
                printf("traced %zu %.6f\n", done, took);
            } else {
                float* depths = malloc(n * 4);
                trace(width, any, coherent, rays, n, depths);
                char path[4096];
                snprintf(path, sizeof path, "%s/%s.depths", argv[1], kind);
                FILE* f = fopen(path, "wb");
                if (!f || fwrite(depths, 4, n, f) != n || fclose(f)) { perror(path); return 1; }
                free(depths);
                printf("written %zu\n", n);
            }
        }
        fflush(stdout);
    }
    return 0;
}
