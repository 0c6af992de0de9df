/* Calls of lib/io to HDF5, counted; one of them fails: what it was asked for is not done, but for
 * what closes, which closes and fails. */
#include "hdf5_calls.h"

#include <hdf5.h>
#include <hdf5_hl.h>

hdf5_calls the_hdf5 = {.fail_at = -1};

void hdf5_calls_reset(long fail_at)
{
  the_hdf5.calls = 0;
  the_hdf5.fail_at = fail_at;
  the_hdf5.failed = NULL;
}

__attribute__((noinline)) static int fails(const char *name)
{
  if (the_hdf5.listing && the_hdf5.places.count < CALL_PLACES)
    the_hdf5.places.at[the_hdf5.places.count++] = call_place(the_hdf5.listing);
  if (the_hdf5.calls++ != the_hdf5.fail_at) return 0;
  the_hdf5.failed = name;
  return 1;
}

#define FAILING(type, name, parameters, ...)               \
  type __real_##name parameters;                           \
  type __wrap_##name parameters;                           \
  type __wrap_##name parameters                            \
  {                                                        \
    return fails(#name) ? -1 : __real_##name(__VA_ARGS__); \
  }

#define CLOSING(name)                  \
  herr_t __real_##name(hid_t id);      \
  herr_t __wrap_##name(hid_t id);      \
  herr_t __wrap_##name(hid_t id)       \
  {                                    \
    herr_t status = __real_##name(id); \
    return fails(#name) ? -1 : status; \
  }

/* 0 is its failure. */
hsize_t __real_H5Dget_storage_size(hid_t a);
hsize_t __wrap_H5Dget_storage_size(hid_t a);
hsize_t __wrap_H5Dget_storage_size(hid_t a)
{
  return fails("H5Dget_storage_size") ? 0 : __real_H5Dget_storage_size(a);
}

FAILING(hid_t, H5Acreate2, (hid_t a, const char *b, hid_t c, hid_t d, hid_t e, hid_t f), a, b, c, d,
        e, f)
FAILING(htri_t, H5Aexists, (hid_t a, const char *b), a, b)
FAILING(hid_t, H5Aget_space, (hid_t a), a)
FAILING(hid_t, H5Aget_type, (hid_t a), a)
FAILING(hid_t, H5Aopen, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(herr_t, H5Aread, (hid_t a, hid_t b, void *c), a, b, c)
FAILING(herr_t, H5Awrite, (hid_t a, hid_t b, const void *c), a, b, c)
FAILING(herr_t, H5DSattach_scale, (hid_t a, hid_t b, unsigned c), a, b, c)
FAILING(herr_t, H5DSset_scale, (hid_t a, const char *b), a, b)
FAILING(hid_t, H5Dcreate2, (hid_t a, const char *b, hid_t c, hid_t d, hid_t e, hid_t f, hid_t g), a,
        b, c, d, e, f, g)
FAILING(hid_t, H5Dget_create_plist, (hid_t a), a)
FAILING(hid_t, H5Dget_space, (hid_t a), a)
FAILING(hid_t, H5Dget_type, (hid_t a), a)
FAILING(hid_t, H5Dopen2, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(herr_t, H5Dread, (hid_t a, hid_t b, hid_t c, hid_t d, hid_t e, void *f), a, b, c, d, e, f)
FAILING(herr_t, H5Dset_extent, (hid_t a, const hsize_t *b), a, b)
FAILING(herr_t, H5Dwrite, (hid_t a, hid_t b, hid_t c, hid_t d, hid_t e, const void *f), a, b, c, d,
        e, f)
FAILING(hid_t, H5Fcreate, (const char *a, unsigned b, hid_t c, hid_t d), a, b, c, d)
FAILING(herr_t, H5Fflush, (hid_t a, H5F_scope_t b), a, b)
FAILING(hid_t, H5Fopen, (const char *a, unsigned b, hid_t c), a, b, c)
FAILING(herr_t, H5Fstart_swmr_write, (hid_t a), a)
FAILING(hid_t, H5Gcreate2, (hid_t a, const char *b, hid_t c, hid_t d, hid_t e), a, b, c, d, e)
FAILING(hid_t, H5Gopen2, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(herr_t, H5Ldelete, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(htri_t, H5LTpath_valid, (hid_t a, const char *b, hbool_t c), a, b, c)
FAILING(htri_t, H5Lexists, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(hid_t, H5Oopen, (hid_t a, const char *b, hid_t c), a, b, c)
FAILING(hid_t, H5Pcreate, (hid_t a), a)
FAILING(int, H5Pget_chunk, (hid_t a, int b, hsize_t *c), a, b, c)
FAILING(H5D_layout_t, H5Pget_layout, (hid_t a), a)
FAILING(int, H5Pget_nfilters, (hid_t a), a)
FAILING(herr_t, H5Pset_alignment, (hid_t a, hsize_t b, hsize_t c), a, b, c)
FAILING(herr_t, H5Pset_alloc_time, (hid_t a, H5D_alloc_time_t b), a, b)
FAILING(herr_t, H5Pset_chunk, (hid_t a, int b, const hsize_t *c), a, b, c)
FAILING(herr_t, H5Pset_create_intermediate_group, (hid_t a, unsigned b), a, b)
FAILING(herr_t, H5Pset_deflate, (hid_t a, unsigned b), a, b)
FAILING(herr_t, H5Pset_driver, (hid_t a, hid_t b, const void *c), a, b, c)
FAILING(herr_t, H5Pset_fclose_degree, (hid_t a, H5F_close_degree_t b), a, b)
FAILING(herr_t, H5Pset_libver_bounds, (hid_t a, H5F_libver_t b, H5F_libver_t c), a, b, c)
FAILING(herr_t, H5Pset_shuffle, (hid_t a), a)
FAILING(hid_t, H5Screate, (H5S_class_t a), a)
FAILING(hid_t, H5Screate_simple, (int a, const hsize_t *b, const hsize_t *c), a, b, c)
FAILING(int, H5Sget_simple_extent_dims, (hid_t a, hsize_t *b, hsize_t *c), a, b, c)
FAILING(int, H5Sget_simple_extent_ndims, (hid_t a), a)
FAILING(hssize_t, H5Sget_simple_extent_npoints, (hid_t a), a)
FAILING(herr_t, H5Sselect_hyperslab,
        (hid_t a, H5S_seloper_t b, const hsize_t *c, const hsize_t *d, const hsize_t *e,
         const hsize_t *f),
        a, b, c, d, e, f)
FAILING(hid_t, H5Tcopy, (hid_t a), a)
FAILING(herr_t, H5Tset_cset, (hid_t a, H5T_cset_t b), a, b)
FAILING(herr_t, H5Tset_size, (hid_t a, size_t b), a, b)

CLOSING(H5Aclose)
CLOSING(H5Dclose)
CLOSING(H5Fclose)
CLOSING(H5Gclose)
CLOSING(H5Oclose)
CLOSING(H5Pclose)
CLOSING(H5Sclose)
CLOSING(H5Tclose)
