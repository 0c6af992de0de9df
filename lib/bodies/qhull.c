/* The hull of points by Qhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, ACM TOMS 22, 1996), which
 * merges facets that lie in one plane up to rounding. Points are given to it within a cube of edge
 * 1 about 0: no scale and no offset costs digits. */
#define _POSIX_C_SOURCE 200809L /* fmemopen */
#include <libqhull_r/qhull_ra.h>

#include "errors.h"
#include "hull.h"
#include "space.h"

static const char where[] = "nsdae_solid";

/* The corners of the facets in order, which is clockwise seen from outside (Geomview's). number: of
 * a vertex by its id, from 1. */
static void read_facets(qhT *qh, const double *point, const double *scaled, int *number,
                        nsdae_hull *h)
{
  facetT *facet;
  vertexT *vertex, **vertexp;
  int corners = 0, faces = 0;
  FORALLfacets
  {
    setT *ring = qh_facet3vertex(qh, facet);
    int at = h->first[faces] + qh_setsize(qh, ring);
    h->first[++faces] = at;
    FOREACHvertex_(ring)
    {
      if (number[vertex->id] == 0) {
        const double *p = point + (vertex->point - scaled);
        memcpy(h->corner + 3 * corners, p, 3 * sizeof *p);
        number[vertex->id] = ++corners;
      }
      h->ring[--at] = number[vertex->id] - 1;
    }
    qh_settempfree(qh, &ring);
  }
  h->corners = corners;
}

static int read_hull(qhT *qh, const double *point, const double *scaled, const nsdae_hull **hull,
                     nsdae_error *error)
{
  int sides = 0;
  facetT *facet;
  if (qh->num_vertices > NSDAE_CORNERS_MAX)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                           "the hull of the points has %d corners, more than %d: give fewer points",
                           qh->num_vertices, NSDAE_CORNERS_MAX);
  FORALLfacets sides += qh_setsize(qh, facet->vertices);
  int *number = calloc((size_t)qh->vertex_id + 1, sizeof *number);
  nsdae_hull *h = number ? nsdae_hull_new(qh->num_vertices, qh->num_facets, sides) : NULL;
  int status = h ? NSDAE_OK : nsdae_error_memory(error, where);
  if (h) {
    int code = setjmp(qh->errexit); /* Qhull leaves its functions by it */
    qh->NOerrexit = code != 0;
    if (code == 0) read_facets(qh, point, scaled, number, h);
    qh->NOerrexit = True;
    status = code ? nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                                    "Qhull finds no order of a face's corners (code %d): leave out "
                                    "points that nearly coincide",
                                    code)
                  : nsdae_hull_close(h, error);
  }
  free(number);
  if (status < 0)
    nsdae_hull_release(h);
  else
    *hull = h;
  return status;
}

/* scaled := points about 0, within a cube of edge 1. 0: all points are one. */
static int scale_points(int points, const double *point, double *scaled)
{
  double low[3], high[3], edge = 0;
  for (int j = 0; j < 3; j++) {
    low[j] = high[j] = point[j];
    for (int i = 1; i < points; i++) {
      low[j] = fmin(low[j], point[3 * i + j]);
      high[j] = fmax(high[j], point[3 * i + j]);
    }
    edge = fmax(edge, high[j] / 2 - low[j] / 2);
  }
  for (int i = 0; i < points; i++)
    for (int j = 0; j < 3; j++)
      scaled[3 * i + j] = (point[3 * i + j] - (low[j] / 2 + high[j] / 2)) / edge / 2;
  return edge > 0;
}

static int refuse_flat(int points, nsdae_error *error)
{
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                         "the %d points of the polyhedron lie in a plane, up to rounding: at least "
                         "four must not",
                         points);
}

int nsdae_hull_create(int points, const double *point, const nsdae_hull **hull, nsdae_error *error)
{
  qhT qhull, *qh = &qhull;
  int left, whole;
  double *scaled = malloc(3 * (size_t)points * sizeof *scaled);
  /* for its messages: no file, which may fail */
#ifdef _WIN32
  FILE *nowhere = fopen("NUL", "w");
#else
  char page[256];
  FILE *nowhere = fmemopen(page, sizeof page, "w");
#endif
  char command[] = "qhull Pp";
  int status = NSDAE_OK;
  if (!scaled || !nowhere) {
    status = nsdae_error_memory(error, where);
  } else if (!scale_points(points, point, scaled)) {
    status = refuse_flat(points, error);
  } else {
    qh_zero(qh, nowhere);
    int code = qh_new_qhull(qh, 3, points, scaled, False, command, NULL, nowhere);
    if (code == qh_ERRnone)
      status = read_hull(qh, point, scaled, hull, error);
    else if (code == qh_ERRmem)
      status = nsdae_error_memory(error, where);
    else
      status = refuse_flat(points, error);
    qh->NOerrexit = True;
    qh_freeqhull(qh, !qh_ALL);
    if (qh->qhmem.LASTsize == 0) { /* its memory was not set up: it forgets these two */
      qh_free(qh->qhmem.sizetable);
      qh_free(qh->qhmem.freelists);
    }
    qh_memfreeshort(qh, &left, &whole);
  }
  free(scaled);
  if (nowhere) fclose(nowhere);
  return status;
}
