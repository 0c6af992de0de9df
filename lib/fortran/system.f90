! nsdae/system.h: the description of a non-smooth multibody system.
!
!   M(q) dv + Phi_q^T dLambda - W_N dLambda_N - W_T dLambda_T = F(t,q,v) dt
!   Phi(t,q) = 0,   0 <= g_N(t,q)  _|_  Lambda_N >= 0,   |Lambda_T| <= mu Lambda_N
!
! Callbacks are functions of the abstract interfaces below. Their arrays have their shapes:
! q [nq], v [nv], M [nv, nv] and so on; outputs come zeroed, so that a callback sets only what is
! not zero. user is what nsdae_system_set_user was given. They return 0 when done, > 0 for a failure
! that a smaller step may avoid, < 0 for one that nothing helps.
!
! Contacts, frictional joints, constraints and entries are numbered from 0, as in C, in the files and in the
! messages: contact i is gap(i + 1).
module nsdae_f_system
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  type, bind(C), public :: nsdae_dims
    integer(c_int) :: nq = 0  ! coordinates, >= 1
    integer(c_int) :: nv = 0  ! velocities, 1 .. nq; 0 means nq
    integer(c_int) :: m = 0   ! bilateral constraints, >= 0
    integer(c_int) :: k = 0   ! contacts, >= 0
    integer(c_int) :: nt = 0  ! tangential directions of every contact: 0 (frictionless), 1 or 2
    integer(c_int) :: f = 0   ! frictional joints: bilateral constraints with friction, 0 .. m
  end type

  ! What can have a name; numbered from 0, as everything is.
  ! headers: constants NSDAE_NAME_ NSDAE_UNIT_SIZE

  ! headers: constants NSDAE_CONTACT_WIDTH

  ! A contact by list: two blocks of v, or a block and the ground. Blocks are numbered from 0; id is
  ! the same of the same pair of features at all times.
  type, bind(C), public :: nsdae_contact
    integer(c_long) :: id = 0
    integer(c_int) :: block(2) = [0, -1]          ! -1: the ground
    real(c_double) :: gap = 0                     ! g_N, negative where they overlap
    real(c_double) :: mu = 0, e_n = 0, e_t = 0    ! friction, restitution, tangential restitution
    real(c_double) :: w(3) = 0                    ! velocity along each direction with v = 0
    real(c_double) :: omega(3) = 0                ! acceleration along each with v' = 0
    ! direction(:, d, s): direction d (the normal, then tangents) over the velocities of block(s)
    real(c_double) :: direction(NSDAE_CONTACT_WIDTH, 3, 2) = 0
    ! of a block with more velocities the address of its directions (nv, 1 + nt)
    type(c_ptr) :: wide(2) = c_null_ptr
  end type

  ! The lists that callbacks fill; they live as long as the call.
  type, public :: nsdae_contact_list
    private
    type(c_ptr) :: handle = c_null_ptr
  end type
  type, public :: nsdae_row_list
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  ! Worst disagreement that nsdae_system_check found.
  type, public :: nsdae_check
    character(len=32) :: term = ''               ! callback, e.g. "constraint_jacobian"
    integer(c_int) :: row = 0, column = 0        ! its entry, from 0
    real(c_double) :: given = 0, difference = 0  ! what it says, what central differences say
    real(c_double) :: error = 0                  ! |given - difference| / (1 + |difference|)
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_check

  abstract interface
    ! callbacks.list: interfaces
    ! callbacks.list: end

    ! The diagonal blocks of M(t,q) [nv of the block squared each], column by column, one after
    ! another.
    integer(c_int) function nsdae_mass_blocks_fn(t, q, M, user)
      import
      real(c_double), intent(in) :: t, q(:)
      real(c_double), intent(inout) :: M(:)
      class(*), intent(inout) :: user
    end function
    ! Phi_q(t,q): nsdae_row_add for every block that a row touches.
    integer(c_int) function nsdae_constraint_rows_fn(t, q, rows, user)
      import
      real(c_double), intent(in) :: t, q(:)
      type(nsdae_row_list), intent(in) :: rows
      class(*), intent(inout) :: user
    end function
    ! nsdae_contact_add for every contact with a gap of at most reach at (t,q).
    integer(c_int) function nsdae_contacts_fn(t, q, v, reach, list, user)
      import
      real(c_double), intent(in) :: t, q(:), v(:), reach
      type(nsdae_contact_list), intent(in) :: list
      class(*), intent(inout) :: user
    end function
  end interface

  ! What the C library hands back to the callbacks below: the sizes, the user's procedures and the
  ! user's variable.
  type :: model
    type(nsdae_dims) :: dims
    class(*), pointer :: user => null()
    ! callbacks.list: procedures
    ! callbacks.list: end
    integer(c_int) :: squares = 0  ! entries of M by blocks
    procedure(nsdae_mass_blocks_fn), pointer, nopass :: mass_blocks => null()
    procedure(nsdae_constraint_rows_fn), pointer, nopass :: constraint_rows => null()
    procedure(nsdae_contacts_fn), pointer, nopass :: contacts => null()
    type(nsdae_error) :: refusal  ! by the module itself, of the last call; C keeps the others
  end type

  ! A system; nothing until nsdae_system_create. Copies are the same system.
  type, public :: nsdae_system
    private
    type(c_ptr) :: handle = c_null_ptr
    type(model), pointer :: model => null()
  end type

  ! What user is where none was set.
  type :: nobody
    integer :: size = 1  ! targets without a size are never associated
  end type
  type(nobody), target, save :: no_user

  public :: no_user, nsdae_system_for_user, system_of, check_state
  ! callbacks.list: public_types
  ! callbacks.list: end
  public :: nsdae_system_create, nsdae_system_destroy, nsdae_system_set_user, &
            nsdae_system_set_contact, nsdae_system_set_frictional_joint, nsdae_system_error, &
            nsdae_system_get_dims, nsdae_system_differences, nsdae_system_check, &
            nsdae_system_handle, nsdae_system_clear_error, nsdae_system_simulations, &
            nsdae_system_unseen, nsdae_system_set_name, nsdae_system_get_name, &
            nsdae_system_get_unit, nsdae_system_set_size
  public :: nsdae_mass_blocks_fn, nsdae_constraint_rows_fn, nsdae_contacts_fn, &
            nsdae_system_set_blocks, nsdae_system_get_blocks, nsdae_system_set_mass_blocks, &
            nsdae_system_set_constraint_rows, nsdae_system_set_contacts, nsdae_contact_add, &
            nsdae_row_add
  ! callbacks.list: public_setters
  ! callbacks.list: end

  interface
    ! headers: functions nsdae_system_ create destroy set_user set_contact clear_error simulations set_name
    ! headers: functions nsdae_system_ set_size get_name get_unit set_frictional_joint error get_dims
    ! headers: functions nsdae_system_ differences unseen check set_blocks get_blocks set_mass_blocks
    ! headers: functions nsdae_system_ set_constraint_rows set_contacts
    ! headers: functions nsdae_ contact_add row_add

    ! callbacks.list: c_setters
    ! callbacks.list: end
  end interface

contains

  ! Makes a description without callbacks. NSDAE_E_ARGUMENT (a size outside its range),
  ! NSDAE_E_MEMORY.
  integer(c_int) function nsdae_system_create(dims, system, error) result(status)
    type(nsdae_dims), intent(in) :: dims
    type(nsdae_system), intent(out) :: system
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    integer :: failed
    status = c_create(dims, system%handle, why)
    call error_from_c(why, error)
    if (status < 0) return
    allocate (system%model, stat=failed)
    if (failed /= 0) then
      call c_destroy(system%handle)
      status = no_memory('nsdae_system_create', error)
      return
    end if
    status = c_get_dims(system%handle, system%model%dims)
    system%model%user => no_user
    status = c_set_user(system%handle, c_loc(system%model))
  end function

  ! For a simulation with a user of its own: what C then hands back, and the same to be released.
  subroutine nsdae_system_for_user(system, user, place, own)
    type(nsdae_system), intent(in) :: system
    class(*), target, intent(inout) :: user
    type(c_ptr), intent(out) :: place
    class(*), pointer, intent(out) :: own
    type(model), pointer :: copy
    integer :: failed
    place = c_null_ptr
    own => null()
    allocate (copy, source=system%model, stat=failed)
    if (failed /= 0) return
    copy%user => user
    place = c_loc(copy)
    own => copy
  end subroutine

  ! A system that C made, with callbacks of its own, as one of the module's; for the other modules.
  integer(c_int) function system_of(handle, system, error) result(status)
    type(c_ptr), intent(in) :: handle
    type(nsdae_system), intent(out) :: system
    type(nsdae_error), intent(out), optional :: error
    integer :: failed
    system%handle = handle
    allocate (system%model, stat=failed)
    if (failed /= 0) then
      call c_destroy(system%handle)
      status = no_memory('nsdae_bodies_system', error)
      return
    end if
    status = c_get_dims(system%handle, system%model%dims)
    system%model%user => no_user
  end function

  ! Releases it; one that was not made is allowed. Simulations of it go on: what they need of it
  ! stays.
  subroutine nsdae_system_destroy(system)
    type(nsdae_system), intent(inout) :: system
    integer(c_int) :: simulations
    simulations = c_simulations(system%handle)
    call c_destroy(system%handle)
    if (associated(system%model) .and. simulations == 0) deallocate (system%model)
    system%model => null()
  end subroutine

  ! Takes note of what a setter was refused: nsdae_sim_create returns it no more.
  subroutine nsdae_system_clear_error(system)
    type(nsdae_system), intent(in) :: system
    call c_clear_error(at(system))
  end subroutine

  ! How many simulations it has now; while there are any, no setter is accepted.
  integer(c_int) function nsdae_system_simulations(system) result(count)
    type(nsdae_system), intent(in) :: system
    count = c_simulations(system%handle)
  end function

  ! The C handle, for programs in both languages; its user pointer is the module's own.
  type(c_ptr) function nsdae_system_handle(system) result(handle)
    type(nsdae_system), intent(in) :: system
    handle = system%handle
  end function

  ! The same for a call that is about to be made: what an earlier one was refused for is past.
  type(c_ptr) function at(system) result(handle)
    type(nsdae_system), intent(in) :: system
    handle = system%handle
    if (associated(system%model)) system%model%refusal%status = NSDAE_OK
  end function

  ! The variable that every callback gets as its last argument: a target that lives as long as the
  ! system.
  integer(c_int) function nsdae_system_set_user(system, user) result(status)
    type(nsdae_system), intent(in) :: system
    class(*), target, intent(inout) :: user
    status = NSDAE_E_ARGUMENT
    if (.not. associated(system%model)) return
    status = c_set_user(at(system), c_loc(system%model))
    if (status == NSDAE_OK) system%model%user => user
  end function

  ! Coefficients of contact 0 <= i < k; all zero at first. mu >= 0: friction; e_n and e_t, 0 .. 1:
  ! normal and tangential restitution.
  ! headers: wrappers nsdae_system_ set_contact

  ! Slide 0 <= j < f: the bilateral constraint of that number, 0 .. m-1, with friction mu >= 0.
  ! headers: wrappers nsdae_system_ set_frictional_joint

  ! Name and unit of number i (from 0) of a kind (NSDAE_NAME_COORDINATE and so on), as in
  ! (system, NSDAE_NAME_COORDINATE, 2, 'theta', 'rad'). NSDAE_E_ARGUMENT: no such kind or number, or
  ! a text that is empty or too long.
  integer(c_int) function nsdae_system_set_name(system, kind, i, name, unit) result(status)
    type(nsdae_system), intent(in) :: system
    integer(c_int), intent(in) :: kind, i
    character(len=*), intent(in) :: name
    character(len=*), intent(in), optional :: unit
    character(kind=c_char) :: c_name(len_trim(name) + 1), empty(1)
    call to_chars(name, c_name)
    empty(1) = c_null_char
    if (present(unit)) then
      status = named(len_trim(unit) + 1)
    else
      status = c_set_name(at(system), kind, i, c_name, empty)
    end if
  contains
    integer(c_int) function named(length) result(status)
      integer, intent(in) :: length
      character(kind=c_char) :: c_unit(length)
      call to_chars(unit, c_unit)
      status = c_set_name(at(system), kind, i, c_name, c_unit)
    end function
  end function

  ! A length that the error of number i (from 0) of a kind is measured by, NSDAE_NAME_CONTACT (of
  ! contacts by list: of block i) or NSDAE_NAME_CONSTRAINT; 0: unknown.
  ! headers: wrappers nsdae_system_ set_size

  ! '' where there is none.
  function nsdae_system_get_name(system, kind, i) result(text)
    type(nsdae_system), intent(in) :: system
    integer(c_int), intent(in) :: kind, i
    character(len=:), allocatable :: text
    text = from_c(c_get_name(system%handle, kind, i))
  end function

  function nsdae_system_get_unit(system, kind, i) result(text)
    type(nsdae_system), intent(in) :: system
    integer(c_int), intent(in) :: kind, i
    character(len=:), allocatable :: text
    text = from_c(c_get_unit(system%handle, kind, i))
  end function

  ! Why the last call on this system failed.
  type(nsdae_error) function nsdae_system_error(system) result(error)
    type(nsdae_system), intent(in) :: system
    if (associated(system%model)) then
      error = system%model%refusal
      if (error%status /= NSDAE_OK) return
    end if
    error = error_at(c_error(system%handle))
  end function

  ! The sizes, with nv filled in.
  ! headers: wrappers nsdae_system_ get_dims

  ! Names of the terms that are filled by differences, e.g. "constraint_bias gap_normal".
  ! headers: wrappers nsdae_system_ differences

  ! What no check can see of the callbacks that are given.
  ! headers: wrappers nsdae_system_ unseen

  ! NSDAE_E_ARGUMENT where q or v, arguments of these names, has not the size it must have; for the other modules
  ! too.
  integer(c_int) function check_state(dims, q_name, q, v_name, v, error) result(status)
    type(nsdae_dims), intent(in) :: dims
    character(len=*), intent(in) :: q_name, v_name
    real(c_double), intent(in) :: q(:), v(:)
    type(nsdae_error), intent(inout) :: error
    status = check_size(q_name, size(q), dims%nq, error)
    if (status == NSDAE_OK) status = check_size(v_name, size(v), dims%nv, error)
  end function

  ! Looks at every callback that is given, at (t, q [nq], v [nv]): what it writes beyond its arrays,
  ! never writes, or writes that is no number; then every derivative against central differences of
  ! what it derives from, the mass matrix against its transpose, and directions of friction that
  ! are none. NSDAE_OK; NSDAE_E_DERIVATIVE with the wrong entry in worst; NSDAE_E_CALLBACK,
  ! NSDAE_E_NONFINITE, NSDAE_E_ARGUMENT, NSDAE_E_STATE, NSDAE_E_MEMORY.
  integer(c_int) function nsdae_system_check(system, t, q, v, tol, worst) result(status)
    type(nsdae_system), intent(in) :: system
    real(c_double), intent(in) :: t, tol
    real(c_double), intent(in), contiguous :: q(:), v(:)
    type(nsdae_check), intent(out), optional :: worst
    type(nsdae_c_check) :: from
    if (associated(system%model)) then
      status = check_state(system%model%dims, 'q', q, 'v', v, system%model%refusal)
      if (status < 0) return
    end if
    status = c_check(at(system), t, q, v, tol, from)
    if (.not. present(worst)) return
    call from_chars(from%term, worst%term)
    worst%row = from%row
    worst%column = from%column
    worst%given = from%given
    worst%difference = from%difference
    worst%error = from%error
  end function

  ! mass and force are always needed, constraint where m > 0, gap where k > 0, gap_tangent where
  ! nt > 0 and any mu > 0, frictional_joint_tangent where a frictional joint has mu > 0; what else is missing is filled by
  ! central differences or taken as zero. NSDAE_E_ARGUMENT: the system has no such term.

  ! callbacks.list: f_setters
  ! callbacks.list: end

  ! Splits q and v into blocks: block b has nq(b + 1) coordinates and nv(b + 1) velocities. The
  ! system takes the callbacks mass_blocks, constraint_rows and contacts then.
  integer(c_int) function nsdae_system_set_blocks(system, nq, nv) result(status)
    type(nsdae_system), intent(in) :: system
    integer(c_int), intent(in), contiguous :: nq(:), nv(:)
    status = NSDAE_E_ARGUMENT
    if (.not. associated(system%model)) return
    status = check_size('nv', size(nv), size(nq), system%model%refusal)
    if (status < 0) return
    status = c_set_blocks(at(system), size(nq), nq, nv)
    if (status == NSDAE_OK) system%model%squares = sum(nv * nv)
  end function

  ! How many there are: 1 where none were set.
  integer(c_int) function nsdae_system_get_blocks(system) result(count)
    type(nsdae_system), intent(in) :: system
    count = c_get_blocks(system%handle)
  end function

  integer(c_int) function nsdae_system_set_mass_blocks(system, mass_blocks) result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_mass_blocks_fn) :: mass_blocks
    status = c_set_mass_blocks(at(system), c_funloc(call_mass_blocks))
    if (status == NSDAE_OK) system%model%mass_blocks => mass_blocks
  end function

  integer(c_int) function nsdae_system_set_constraint_rows(system, constraint_rows) result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_constraint_rows_fn) :: constraint_rows
    status = c_set_constraint_rows(at(system), c_funloc(call_constraint_rows))
    if (status == NSDAE_OK) system%model%constraint_rows => constraint_rows
  end function

  integer(c_int) function nsdae_system_set_contacts(system, contacts) result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_contacts_fn) :: contacts
    status = c_set_contacts(at(system), c_funloc(call_contacts))
    if (status == NSDAE_OK) system%model%contacts => contacts
  end function

  ! Adds a copy to the list of the callback contacts. NSDAE_OK, NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE.
  integer(c_int) function nsdae_contact_add(list, contact) result(status)
    type(nsdae_contact_list), intent(in) :: list
    type(nsdae_contact), intent(in) :: contact
    status = c_contact_add(list%handle, contact)
  end function

  ! values [nv of the block]: the entries of row 0 <= row < m over a block (from 0). Rows come in
  ! ascending order, each block once.
  integer(c_int) function nsdae_row_add(rows, row, block, values) result(status)
    type(nsdae_row_list), intent(in) :: rows
    integer(c_int), intent(in) :: row, block
    real(c_double), intent(in), contiguous :: values(:)
    status = c_row_add(rows%handle, row, block, values)
  end function

  ! What C calls: each finds the user's procedure and gives its arrays their shapes. Nothing is
  ! copied.

  function model_at(p) result(here)
    type(c_ptr), intent(in) :: p
    type(model), pointer :: here
    call c_f_pointer(p, here)
  end function

  ! What may be NULL where it is empty.
  function array_at(p, n) result(a)
    type(c_ptr), intent(in) :: p
    integer(c_int), intent(in) :: n
    real(c_double), pointer :: a(:)
    real(c_double), target, save :: nothing(1)
    a => nothing(:0)
    if (n > 0) call c_f_pointer(p, a, [n])
  end function

  ! callbacks.list: calls
  ! callbacks.list: end

  integer(c_int) function call_mass_blocks(t, q, M, user) result(status) bind(C, name='')
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    real(c_double), intent(inout) :: M(*)
    type(c_ptr), value :: user
    type(model), pointer :: here
    here => model_at(user)
    status = here%mass_blocks(t, q(:here%dims%nq), M(:here%squares), here%user)
  end function

  integer(c_int) function call_constraint_rows(t, q, rows, user) result(status) bind(C, name='')
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    type(c_ptr), value :: rows, user
    type(model), pointer :: here
    type(nsdae_row_list) :: list
    here => model_at(user)
    list%handle = rows
    status = here%constraint_rows(t, q(:here%dims%nq), list, here%user)
  end function

  integer(c_int) function call_contacts(t, q, v, reach, contacts, user) &
      result(status) bind(C, name='')
    real(c_double), value :: t, reach
    real(c_double), intent(in) :: q(*), v(*)
    type(c_ptr), value :: contacts, user
    type(model), pointer :: here
    type(nsdae_contact_list) :: list
    here => model_at(user)
    list%handle = contacts
    associate (d => here%dims)
      status = here%contacts(t, q(:d%nq), v(:d%nv), reach, list, here%user)
    end associate
  end function

end module
