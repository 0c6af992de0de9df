// Callbacks: functions of Python, with arrays that are created once, and addresses of compiled
// functions.
#ifndef NSDAE_PYTHON_CALLBACKS_HPP
#define NSDAE_PYTHON_CALLBACKS_HPP

#include <vector>

#include <nanobind/nanobind.h>

#include "lists.hpp"

namespace nsdae_python
{

namespace nb = nanobind;

// An argument that is an array, as the function sees it: [rows], or [rows x columns] column-major.
struct slot {
  int rows, columns; // columns 0: a vector
  bool written;      // by the function; others are read-only
};

// The arrays of one call and the memory under them. They belong to Python: a function may keep
// them.
struct frame {
  std::vector<PyObject *> array;
  std::vector<double *> memory;
};

// A callback of a description: a function of Python, or an address with its user argument.
class callback
{
public:
  ~callback() { clear(); }
  void set_function(PyObject *f, const std::vector<slot> &of, bool returns);
  void set_pointer(void *address, void *with);
  void clear();
  bool given() const { return function || pointer; }

  PyObject *function = nullptr;
  void *pointer = nullptr, *user = nullptr;
  std::vector<slot> slots;
  bool value = false;                // the function returns its result, a number
  const partition *blocks = nullptr; // of callbacks that fill a list
  frame arrays;
  bool busy = false; // the arrays are in use by another thread or an outer call
};

// One call of a function of Python: put() its arguments in their order, then run(). The GIL is
// taken by the constructor and given back at the end.
class call
{
public:
  explicit call(callback &c);
  ~call();
  call(const call &) = delete;
  call &operator=(const call &) = delete;
  void put(double t);
  void put(const double *in);
  void put(double *out);
  void put(int ld);
  void put(nsdae_contact_list *list) { hand(contacts, list); }
  void put(nsdae_row_list *list) { hand(rows, list); }
  void put(nsdae_block_list *list) { hand(blocks, list); }
  void put(void *) {} // user
  int run();

private:
  template <class L> void hand(open_list<L> *&made, L *list);
  void copy_out();
  int judge(PyObject *result);

  nb::gil_scoped_acquire gil;
  callback &of;
  frame own, *in_use;
  bool taken;
  PyObject *argument[8] = {};
  bool is_own[8] = {}; // of the call; the arrays are the frame's
  int arguments = 0;
  contact_list *contacts = nullptr; // the lists of Python
  row_list *rows = nullptr;
  block_list *blocks = nullptr;
  struct target {
    double *at;
    int ld;
  } to[8] = {};
  int used = 0;
};

// Exception of a callback on this thread, until the call of the library returns; the function.
void remember_exception(PyObject *function = nullptr);
bool exception_pending();
[[noreturn]] void raise_pending();

} // namespace nsdae_python

#endif
