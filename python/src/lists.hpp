// Lists that callbacks of block-sparse systems fill: contact list and rows of Phi_q.
#ifndef NSDAE_PYTHON_LISTS_HPP
#define NSDAE_PYTHON_LISTS_HPP

#include <cstdint>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nsdae/nsdae.h>

namespace nsdae_python
{

namespace nb = nanobind;

template <int N>
using reals = nb::ndarray<const double, nb::ndim<N>, nb::c_contig, nb::device::cpu>;
template <int N>
using ids = nb::ndarray<const std::int64_t, nb::ndim<N>, nb::c_contig, nb::device::cpu>;

// Blocks of q and v; empty: none.
struct partition {
  std::vector<int> nq, nv;
  int nt = 0; // tangential directions of a contact
};

// A list in Python; it is valid during its callback.
template <class L> struct open_list {
  L *list;
  const partition *of;
  L *opened() const;
};

using contact_list = open_list<nsdae_contact_list>;
using row_list = open_list<nsdae_row_list>;
using block_list = open_list<nsdae_block_list>;

void bind_lists(nb::module_ &m);

} // namespace nsdae_python

#endif
