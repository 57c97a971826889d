/* SPDX-License-Identifier: MIT
 * Collapses the edges of half a surface in the order of their quadric error (Garland and Heckbert 1997). An edge goes
 * only if the surface stays a manifold (the link condition), no triangle folds over or becomes a needle, and the
 * boundary, which joins the half to its mirror image, stays in the plane y = 0. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh.h"

#define NEEDLE 0.05 /* twice the area of a triangle over the square of its longest edge; 0.87 at best */

/* x^T A x + 2 b x + c, A symmetric. */
typedef struct {
    double xx, xy, xz, yy, yz, zz, bx, by, bz, c;
} quadric;

typedef struct {
    double cost;
    int u, v, stamp_u, stamp_v;
    vec to;
} candidate;

typedef struct {
    mesh* m;
    int *head, *next, *tail; /* corners 3 t + p of the triangles around a vertex */
    int* stamp;              /* changes whenever the surroundings of a vertex do; -1: gone */
    char* alive;             /* triangles */
    quadric* q;
    candidate* heap;
    int heap_n, heap_room;
    int* mark;
    int marks;
} simplifier;

static vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static double dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec minus(vec a, vec b) {
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static void add_quadric(quadric* a, const quadric* b) {
    a->xx += b->xx, a->xy += b->xy, a->xz += b->xz, a->yy += b->yy, a->yz += b->yz, a->zz += b->zz;
    a->bx += b->bx, a->by += b->by, a->bz += b->bz, a->c += b->c;
}

static double quadric_at(const quadric* q, vec p) {
    return q->xx * p.x * p.x + q->yy * p.y * p.y + q->zz * p.z * p.z +
           2 * (q->xy * p.x * p.y + q->xz * p.x * p.z + q->yz * p.y * p.z + q->bx * p.x + q->by * p.y + q->bz * p.z) +
           q->c;
}

/* Squared distance from a plane, times a weight. */
static quadric plane_quadric(vec n, double d, double w) {
    return (quadric){w * n.x * n.x, w * n.x * n.y, w * n.x * n.z, w * n.y * n.y, w * n.y * n.z,
                     w * n.z * n.z, w * n.x * d,   w * n.y * d,   w * n.z * d,   w * d * d};
}

static quadric point_quadric(vec p, double w) {
    return (quadric){w, 0, 0, w, 0, w, -w * p.x, -w * p.y, -w * p.z, w * dot(p, p)};
}

static vec minimum(const quadric* q) {
    const double a = q->yy * q->zz - q->yz * q->yz, b = q->xz * q->yz - q->xy * q->zz,
                 c = q->xy * q->yz - q->xz * q->yy;
    const double d = q->xx * q->zz - q->xz * q->xz, e = q->xy * q->xz - q->xx * q->yz,
                 f = q->xx * q->yy - q->xy * q->xy;
    const double det = q->xx * a + q->xy * b + q->xz * c;
    return (vec){-(a * q->bx + b * q->by + c * q->bz) / det, -(b * q->bx + d * q->by + e * q->bz) / det,
                 -(c * q->bx + e * q->by + f * q->bz) / det};
}

static int on_boundary(const simplifier* s, int v) {
    return s->m->vertex[v].y == 0.0;
}

static void prepare_quadrics(simplifier* s) {
    const mesh* m = s->m;
    for (int t = 0; t < m->triangles; ++t) {
        const int* c = m->triangle[t];
        const vec a = m->vertex[c[0]];
        vec n = cross(minus(m->vertex[c[1]], a), minus(m->vertex[c[2]], a));
        const double twice = sqrt(dot(n, n));
        quadric plane;
        if (!(twice > 0.0)) continue;
        n = (vec){n.x / twice, n.y / twice, n.z / twice};
        for (int p = 0; p < 3; ++p) {
            quadric* q = &s->q[c[p]];
            const quadric point = point_quadric(m->vertex[c[p]], 4e-4 * twice);
            plane = plane_quadric(n, -dot(n, a), twice);
            add_quadric(q, &plane);
            add_quadric(q, &point);
            if (!on_boundary(s, c[p])) continue;
            n.y = -n.y; /* the mirror image counts too: the optimum then lies in the plane */
            plane = plane_quadric(n, -dot(n, a), twice);
            add_quadric(q, &plane);
            n.y = -n.y;
        }
    }
}

static int before(const candidate* a, const candidate* b) {
    if (a->cost != b->cost) return a->cost < b->cost;
    if (a->u != b->u) return a->u < b->u;
    return a->v < b->v;
}

static void push(simplifier* s, const candidate* c) {
    int i = s->heap_n++;
    if (i == s->heap_room) {
        candidate* more = shapes_memory(2 * (unsigned long)s->heap_room + 1024, sizeof(candidate));
        memcpy(more, s->heap, (size_t)i * sizeof(candidate));
        free(s->heap);
        s->heap = more;
        s->heap_room = 2 * s->heap_room + 1024;
    }
    for (; i > 0 && before(c, &s->heap[(i - 1) / 2]); i = (i - 1) / 2) s->heap[i] = s->heap[(i - 1) / 2];
    s->heap[i] = *c;
}

static candidate pop(simplifier* s) {
    const candidate top = s->heap[0], last = s->heap[--s->heap_n];
    int i = 0;
    for (;;) {
        int child = 2 * i + 1;
        if (child >= s->heap_n) break;
        if (child + 1 < s->heap_n && before(&s->heap[child + 1], &s->heap[child])) ++child;
        if (!before(&s->heap[child], &last)) break;
        s->heap[i] = s->heap[child];
        i = child;
    }
    s->heap[i] = last;
    return top;
}

static void propose(simplifier* s, int u, int v) {
    quadric q = s->q[u];
    candidate c = {.u = u < v ? u : v, .v = u < v ? v : u};
    const int flat = on_boundary(s, u) || on_boundary(s, v);
    add_quadric(&q, &s->q[v]);
    if (flat) q.yy += 1e6 * (q.xx + q.yy + q.zz);
    c.to = minimum(&q);
    if (flat) {
        c.to.y = 0.0;
        q = s->q[u];
        add_quadric(&q, &s->q[v]);
    } else if (c.to.y < 1e-4) {
        c.to.y = 1e-4;
    }
    c.cost = quadric_at(&q, c.to);
    c.stamp_u = s->stamp[c.u], c.stamp_v = s->stamp[c.v];
    push(s, &c);
}

#define FOR_CORNERS(s, v, c) for (int c = (s)->head[v]; c >= 0; c = (s)->next[c])

/* Neighbours that u and v share must be the tips of the triangles on the edge, and an edge inside the half may not come
 * to join two points of its boundary. */
static int stays_manifold(simplifier* s, int u, int v) {
    const mesh* m = s->m;
    int tips = 0, shared = 0, boundary_v = 0;
    const int both = on_boundary(s, u) && on_boundary(s, v);
    ++s->marks;
    FOR_CORNERS(s, u, c) {
        const int* t = m->triangle[c / 3];
        if (!s->alive[c / 3]) continue;
        if (t[0] == v || t[1] == v || t[2] == v) ++tips;
        for (int p = 0; p < 3; ++p) s->mark[t[p]] = s->marks;
    }
    if (tips != (both ? 1 : 2)) return 0;
    ++s->marks;
    FOR_CORNERS(s, v, c) {
        const int* t = m->triangle[c / 3];
        if (!s->alive[c / 3]) continue;
        for (int p = 0; p < 3; ++p) {
            const int w = t[p];
            if (w == u || w == v || s->mark[w] == s->marks) continue;
            if (s->mark[w] == s->marks - 1) ++shared;
            if (on_boundary(s, w) && s->mark[w] != s->marks - 1) ++boundary_v;
            s->mark[w] = s->marks;
        }
    }
    if (shared != tips) return 0;
    if (both) return 1;
    /* One of the two on the boundary: the other one may touch it only at the first or beside it. */
    if (on_boundary(s, u)) return boundary_v == 0;
    if (on_boundary(s, v)) return stays_manifold(s, v, u);
    return 1;
}

static double longest_squared(vec a, vec b, vec c) {
    const vec e = minus(a, b), f = minus(b, c), g = minus(c, a);
    const double ee = dot(e, e), ff = dot(f, f), gg = dot(g, g), m = ee > ff ? ee : ff;
    return m > gg ? m : gg;
}

/* Whether a triangle around u, but not v, turns by more than 70 degrees or becomes a needle when u moves; one that is a
 * needle already may not get worse. */
static int folds(const simplifier* s, int u, int v, vec to) {
    const mesh* m = s->m;
    FOR_CORNERS(s, u, c) {
        const int *t = m->triangle[c / 3], p = c % 3;
        const vec a = m->vertex[t[(p + 1) % 3]], b = m->vertex[t[(p + 2) % 3]], from = m->vertex[u];
        vec n0, n1;
        double area0, area1, shape0, shape1;
        if (!s->alive[c / 3] || t[0] == v || t[1] == v || t[2] == v) continue;
        n0 = cross(minus(a, from), minus(b, from)), n1 = cross(minus(a, to), minus(b, to));
        area0 = sqrt(dot(n0, n0)), area1 = sqrt(dot(n1, n1));
        shape0 = area0 / longest_squared(a, b, from), shape1 = area1 / longest_squared(a, b, to);
        if (shape1 < NEEDLE && shape1 <= shape0) return 1;
        if (dot(n0, n1) < 0.34 * area0 * area1) return 1;
    }
    return 0;
}

static int collapse(simplifier* s, const candidate* c) {
    mesh* m = s->m;
    const int u = c->u, v = c->v;
    int gone = 0;
    vec to = c->to;
    if (!stays_manifold(s, u, v)) return 0;
    if (folds(s, u, v, to) || folds(s, v, u, to)) { /* the better of its ends, if that folds nothing */
        if (on_boundary(s, u) != on_boundary(s, v))
            to = m->vertex[on_boundary(s, u) ? u : v];
        else
            to = m->vertex[quadric_at(&s->q[u], m->vertex[v]) < quadric_at(&s->q[v], m->vertex[u]) ? v : u];
        if (folds(s, u, v, to) || folds(s, v, u, to)) return 0;
    }
    m->vertex[u] = to;
    add_quadric(&s->q[u], &s->q[v]);
    FOR_CORNERS(s, v, k) {
        int* t = m->triangle[k / 3];
        if (!s->alive[k / 3]) continue;
        if (t[0] == u || t[1] == u || t[2] == u) {
            s->alive[k / 3] = 0;
            ++gone;
        } else {
            t[k % 3] = u;
        }
    }
    s->next[s->tail[u]] = s->head[v];
    s->tail[u] = s->tail[v];
    s->stamp[v] = -1;
    ++s->stamp[u];
    /* Dead corners leave the list, so that it stays as short as the ring is. */
    for (int *link = &s->head[u], last = -1;;) {
        const int k = *link;
        if (k < 0) {
            s->tail[u] = last;
            break;
        }
        if (!s->alive[k / 3]) {
            *link = s->next[k];
        } else {
            last = k;
            link = &s->next[k];
        }
    }
    ++s->marks;
    FOR_CORNERS(s, u, k) {
        for (int p = 0; p < 3; ++p) {
            const int w = m->triangle[k / 3][p];
            if (w == u || s->mark[w] == s->marks) continue;
            s->mark[w] = s->marks;
            propose(s, u, w);
        }
    }
    return gone;
}

static void compact(simplifier* s) {
    mesh* m = s->m;
    int* number = shapes_memory((unsigned long)m->vertices, sizeof(int));
    int vertices = 0, triangles = 0;
    for (int t = 0; t < m->triangles; ++t) {
        if (!s->alive[t]) continue;
        memmove(m->triangle[triangles], m->triangle[t], sizeof(int[3]));
        for (int p = 0; p < 3; ++p) number[m->triangle[t][p]] = 1;
        ++triangles;
    }
    for (int v = 0; v < m->vertices; ++v) {
        if (!number[v]) continue;
        m->vertex[vertices] = m->vertex[v];
        number[v] = vertices++;
    }
    for (int t = 0; t < triangles; ++t)
        for (int p = 0; p < 3; ++p) m->triangle[t][p] = number[m->triangle[t][p]];
    m->vertices = vertices;
    m->triangles = triangles;
    free(number);
}

static void propose_all(simplifier* s) {
    const mesh* m = s->m;
    s->heap_n = 0;
    for (int c = 0; c < 3 * m->triangles; ++c) {
        const int u = m->triangle[c / 3][c % 3], v = m->triangle[c / 3][(c + 1) % 3];
        if (s->alive[c / 3] && (u < v || (on_boundary(s, u) && on_boundary(s, v)))) propose(s, u, v);
    }
}

void mesh_simplify(mesh* m, int most) {
    const unsigned long nv = (unsigned long)m->vertices, nt = (unsigned long)m->triangles;
    simplifier s = {.m = m};
    int left = m->triangles;
    s.head = shapes_memory(nv, sizeof(int)), s.tail = shapes_memory(nv, sizeof(int));
    s.stamp = shapes_memory(nv, sizeof(int)), s.mark = shapes_memory(nv, sizeof(int));
    s.next = shapes_memory(3 * nt, sizeof(int)), s.alive = shapes_memory(nt, 1);
    s.q = shapes_memory(nv, sizeof(quadric));
    for (int v = 0; v < m->vertices; ++v) s.head[v] = -1;
    for (int c = 0; c < 3 * m->triangles; ++c) {
        const int v = m->triangle[c / 3][c % 3];
        if (s.head[v] < 0)
            s.head[v] = c;
        else
            s.next[s.tail[v]] = c;
        s.tail[v] = c;
        s.next[c] = -1;
        s.alive[c / 3] = 1;
    }
    prepare_quadrics(&s);
    /* What could not go may go once its surroundings have changed. */
    for (int begun = left + 1; left > most && left < begun;) {
        begun = left;
        propose_all(&s);
        while (left > most && s.heap_n > 0) {
            const candidate c = pop(&s);
            if (s.stamp[c.u] == c.stamp_u && s.stamp[c.v] == c.stamp_v) left -= collapse(&s, &c);
        }
    }
    compact(&s);
    free(s.head), free(s.tail), free(s.stamp), free(s.mark), free(s.next), free(s.alive), free(s.q), free(s.heap);
}
