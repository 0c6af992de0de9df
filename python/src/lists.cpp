#include "lists.hpp"

#include <algorithm>
#include <climits>
#include <stdexcept>
#include <string>

namespace nsdae_python
{

namespace
{

// Numbers outside the range of int are invalid; the library refuses them.
int whole(std::int64_t number)
{
  return number < INT_MIN || number > INT_MAX ? INT_MIN : static_cast<int>(number);
}

// Directions of side s of a contact, [1 + nt, width], of which the block has n: stored in the
// contact, or packed into wide. The library refuses unknown blocks.
void put_side(nsdae_contact &c, int s, const double *from, std::size_t width, const partition &of,
              std::vector<double> &wide)
{
  int b = c.block[s];
  if (b < 0 || static_cast<std::size_t>(b) >= of.nv.size()) return;
  std::size_t n = static_cast<std::size_t>(of.nv[static_cast<std::size_t>(b)]);
  if (n > width)
    throw std::invalid_argument("direction has " + std::to_string(width) + " columns; block " +
                                std::to_string(b) + " has " + std::to_string(n) + " velocities");
  std::size_t rows = static_cast<std::size_t>(1 + of.nt);
  bool fits = n <= NSDAE_CONTACT_WIDTH;
  if (!fits) wide.resize(rows * n);
  for (std::size_t d = 0; d < rows; d++)
    std::copy(from + d * width, from + d * width + n, fits ? c.direction[s][d] : &wide[d * n]);
  if (!fits) c.wide[s] = wide.data();
}

// id [n], block [n, 2], gap [n], law [n, 3] = mu, e_n, e_t, w and omega [n, 1 + nt], direction [n,
// 2, 1 + nt, width]: Python checks the shapes. The library reports refused values when the step
// fails.
void add_contacts(const contact_list &to, ids<1> id, ids<2> block, reals<1> gap, reals<2> law,
                  reals<2> w, bool omega_given, reals<2> omega, reals<4> direction)
{
  nsdae_contact_list *list = to.opened();
  std::size_t rows = static_cast<std::size_t>(1 + to.of->nt), width = direction.shape(3);
  std::vector<double> wide[2];
  for (std::size_t i = 0; i < id.shape(0); i++) {
    nsdae_contact c = {};
    c.id = static_cast<long>(id(i));
    c.gap = gap(i);
    c.mu = law(i, 0);
    c.e_n = law(i, 1);
    c.e_t = law(i, 2);
    c.omega_given = omega_given;
    for (std::size_t d = 0; d < rows; d++) c.w[d] = w(i, d), c.omega[d] = omega(i, d);
    for (std::size_t s = 0; s < 2; s++) {
      c.block[s] = whole(block(i, s));
      put_side(c, static_cast<int>(s), direction.data() + (2 * i + s) * rows * width, width, *to.of,
               wide[s]);
    }
    nsdae_contact_add(list, &c);
  }
}

// row [n], block [n], value [n, width].
void add_rows(const row_list &to, ids<1> row, ids<1> block, reals<2> value)
{
  nsdae_row_list *list = to.opened();
  for (std::size_t i = 0; i < row.shape(0); i++) {
    std::size_t b = static_cast<std::size_t>(block(i));
    if (b < to.of->nv.size() && static_cast<std::size_t>(to.of->nv[b]) > value.shape(1))
      throw std::invalid_argument("value has " + std::to_string(value.shape(1)) +
                                  " columns; block " + std::to_string(b) + " has " +
                                  std::to_string(to.of->nv[b]) + " velocities");
    nsdae_row_add(list, whole(row(i)), whole(block(i)), value.data() + i * value.shape(1));
  }
}

// Blocks: row [n], column [n], value [n, rows, columns], of which each block takes its nv.
void add_blocks(const block_list &to, ids<1> row, ids<1> column, reals<3> value)
{
  nsdae_block_list *list = to.opened();
  const std::vector<int> &nv = to.of->nv;
  std::vector<double> packed;
  for (std::size_t i = 0; i < row.shape(0); i++) {
    std::size_t r = static_cast<std::size_t>(row(i)), c = static_cast<std::size_t>(column(i));
    std::size_t m = r < nv.size() ? static_cast<std::size_t>(nv[r]) : 0;
    std::size_t n = c < nv.size() ? static_cast<std::size_t>(nv[c]) : 0;
    if (m > value.shape(1) || n > value.shape(2))
      throw std::invalid_argument("value has the shape (" + std::to_string(value.shape(1)) + ", " +
                                  std::to_string(value.shape(2)) + "); block (" +
                                  std::to_string(r) + ", " + std::to_string(c) + ") has " +
                                  std::to_string(m) + " by " + std::to_string(n));
    packed.resize(m * n + 1);
    for (std::size_t k = 0; k < m; k++)
      for (std::size_t l = 0; l < n; l++) packed[k + l * m] = value(i, k, l);
    nsdae_block_add(list, whole(row(i)), whole(column(i)), packed.data());
  }
}

} // namespace

template <class L> L *open_list<L>::opened() const
{
  if (!list) throw std::invalid_argument("the list holds until the callback returns");
  return list;
}

void bind_lists(nb::module_ &m)
{
  nb::class_<contact_list>(m, "ContactList")
      .def("add", &add_contacts)
      .def_prop_ro("nt", [](const contact_list &l) { return l.of->nt; });
  nb::class_<row_list>(m, "RowList").def("add", &add_rows);
  nb::class_<block_list>(m, "BlockList").def("add", &add_blocks);
  m.attr("CONTACT_SIZE") = sizeof(nsdae_contact);
  // functions, because an attribute would be an address of this process in the stub
  m.def("contact_add", [] { return reinterpret_cast<std::uintptr_t>(&nsdae_contact_add); });
  m.def("row_add", [] { return reinterpret_cast<std::uintptr_t>(&nsdae_row_add); });
  m.def("block_add", [] { return reinterpret_cast<std::uintptr_t>(&nsdae_block_add); });
}

} // namespace nsdae_python
