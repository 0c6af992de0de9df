/* See hull.h, in a library that was built without Qhull. */
#include "errors.h"
#include "hull.h"

int nsdae_hull_create(int points, const double *point, const nsdae_hull **hull, nsdae_error *error)
{
  (void)point;
  (void)hull;
  return nsdae_error_set(error, NSDAE_E_UNSUPPORTED, "nsdae_solid", "shape",
                         "a polyhedron of %d points needs Qhull, which this library was built "
                         "without: install libqhull-dev and build with -DNSDAE_QHULL=ON",
                         points);
}
