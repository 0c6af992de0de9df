! nsdae/system.h: description of a non-smooth multibody system.
!
!   M(q) dv + Phi_q^T dLambda - W_N dLambda_N - W_T dLambda_T = F(t,q,v) dt
!   Phi(t,q) = 0,   0 <= g_N(t,q)  _|_  Lambda_N >= 0,   |Lambda_T| <= mu Lambda_N
!
! Callbacks are functions of the abstract interfaces below. Their arrays have their shapes: q [nq],
! v [nv], M [nv, nv] and so on. Outputs are zero on entry; a callback writes only nonzero entries.
! user is the argument of nsdae_system_set_user. Callbacks return 0: success; > 0: failure that a
! smaller step may avoid; < 0: fatal failure.
!
! Contacts, frictional joints, constraints and entries are numbered from 0, as in C, files and
! messages: contact i is gap(i + 1).
module nsdae_f_system
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  type, bind(C), public :: nsdae_dims
    integer(c_int) :: nq = 0  ! coordinates, >= 1
    integer(c_int) :: nv = 0  ! velocities, 1 .. nq; 0: nq
    integer(c_int) :: m = 0   ! bilateral constraints, >= 0
    integer(c_int) :: k = 0   ! contacts, >= 0
    integer(c_int) :: nt = 0  ! tangential directions of every contact: 0 (frictionless), 1 or 2
    integer(c_int) :: f = 0   ! frictional joints: bilateral constraints with friction, 0 .. m
  end type

  ! What can have a name; numbered from 0, as everything is.
  ! headers: constants NSDAE_NAME_ NSDAE_UNIT_SIZE

  ! headers: constants NSDAE_CONTACT_WIDTH

  ! A contact of a contact list: between two blocks of v, or a block and the ground. Blocks are
  ! numbered from 0; id identifies a pair of features at all times.
  type, bind(C), public :: nsdae_contact
    integer(c_long) :: id = 0
    integer(c_int) :: block(2) = [0, -1]          ! -1: the ground
    real(c_double) :: gap = 0                     ! g_N, negative for an overlap
    real(c_double) :: mu = 0, e_n = 0, e_t = 0    ! friction, restitution, tangential restitution
    real(c_double) :: w(3) = 0                    ! velocity along each direction at v = 0
    real(c_double) :: omega(3) = 0                ! acceleration along each at v' = 0
    integer(c_int) :: omega_given = 0             ! 1: omega is set; 0: computed by differences
    ! direction(:, d, s): direction d (the normal, then tangents) over the velocities of block(s)
    real(c_double) :: direction(NSDAE_CONTACT_WIDTH, 3, 2) = 0
    ! null, or for a block with more velocities the address of its directions (nv, 1 + nt)
    type(c_ptr) :: wide(2) = c_null_ptr
  end type

  ! The lists that callbacks fill; valid during the call.
  type, public :: nsdae_contact_list
    private
    type(c_ptr) :: handle = c_null_ptr
  end type
  type, public :: nsdae_row_list
    private
    type(c_ptr) :: handle = c_null_ptr
  end type
  type, public :: nsdae_block_list
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  ! Largest error that nsdae_system_check found.
  type, public :: nsdae_check
    character(len=32) :: term = ''               ! callback, e.g. "constraint_jacobian"
    integer(c_int) :: row = 0, column = 0        ! its entry, from 0
    real(c_double) :: given = 0, difference = 0  ! values of callback and central differences
    real(c_double) :: error = 0                  ! |given - difference| / (1 + |difference|)
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_check

  abstract interface
    ! callbacks.list: interfaces
    ! callbacks.list: end

    ! Diagonal blocks of M(t,q), nv x nv of the block each, column-major, one after another.
    integer(c_int) function nsdae_mass_blocks_fn(t, q, M, user)
      import
      real(c_double), intent(in) :: t, q(:)
      real(c_double), intent(inout) :: M(:)
      class(*), intent(inout) :: user
    end function
    ! Phi_q(t,q): calls nsdae_row_add for every block of every row.
    integer(c_int) function nsdae_constraint_rows_fn(t, q, rows, user)
      import
      real(c_double), intent(in) :: t, q(:)
      type(nsdae_row_list), intent(in) :: rows
      class(*), intent(inout) :: user
    end function
    ! W_S^T(t,q) by rows, from 0, as nsdae_constraint_rows_fn, and w_s(t,q) [f].
    integer(c_int) function nsdae_joint_friction_rows_fn(t, q, rows, w_s, user)
      import
      real(c_double), intent(in) :: t, q(:)
      type(nsdae_row_list), intent(in) :: rows
      real(c_double), intent(inout) :: w_s(:)
      class(*), intent(inout) :: user
    end function
    ! D = -dF/dv or K = -(dF/dq) H by blocks: calls nsdae_block_add for the blocks that are not zero.
    integer(c_int) function nsdae_force_blocks_fn(t, q, v, blocks, user)
      import
      real(c_double), intent(in) :: t, q(:), v(:)
      type(nsdae_block_list), intent(in) :: blocks
      class(*), intent(inout) :: user
    end function
    ! Calls nsdae_contact_add for every contact with a gap of at most reach at (t,q).
    integer(c_int) function nsdae_contacts_fn(t, q, v, reach, list, user)
      import
      real(c_double), intent(in) :: t, q(:), v(:), reach
      type(nsdae_contact_list), intent(in) :: list
      class(*), intent(inout) :: user
    end function
  end interface

  ! The user pointer of the C callbacks below: sizes, the user's procedures, the user's variable.
  type :: model
    type(nsdae_dims) :: dims
    class(*), pointer :: user => null()
    ! callbacks.list: procedures
    ! callbacks.list: end
    integer(c_int) :: squares = 0  ! entries of the diagonal blocks of M
    procedure(nsdae_mass_blocks_fn), pointer, nopass :: mass_blocks => null()
    procedure(nsdae_constraint_rows_fn), pointer, nopass :: constraint_rows => null()
    procedure(nsdae_joint_friction_rows_fn), pointer, nopass :: joint_friction_rows => null()
    procedure(nsdae_force_blocks_fn), pointer, nopass :: force_damping_blocks => null()
    procedure(nsdae_force_blocks_fn), pointer, nopass :: force_stiffness_blocks => null()
    procedure(nsdae_contacts_fn), pointer, nopass :: contacts => null()
    type(nsdae_error) :: refusal  ! error of the module in the last call; C has the others
  end type

  ! A system; empty before nsdae_system_create. Copies refer to the same system.
  type, public :: nsdae_system
    private
    type(c_ptr) :: handle = c_null_ptr
    type(model), pointer :: model => null()
  end type

  ! The default of user.
  type :: nobody
    integer :: size = 1  ! targets without a size are never associated
  end type
  type(nobody), target, save :: no_user

  public :: no_user, nsdae_system_for_user, system_of, check_state
  ! callbacks.list: public_types
  ! callbacks.list: end
  public :: nsdae_system_create, nsdae_system_destroy, nsdae_system_set_user, &
            nsdae_system_set_contact, nsdae_system_set_frictional_joint, nsdae_system_error, &
            nsdae_system_set_friction_bound, nsdae_system_set_friction_circle, &
            nsdae_system_get_dims, nsdae_system_differences, nsdae_system_check, &
            nsdae_system_handle, nsdae_system_clear_error, nsdae_system_simulations, &
            nsdae_system_unseen, nsdae_system_set_name, nsdae_system_get_name, &
            nsdae_system_get_unit, nsdae_system_set_size, nsdae_system_sensor_size
  public :: nsdae_mass_blocks_fn, nsdae_constraint_rows_fn, nsdae_contacts_fn, &
            nsdae_system_set_blocks, nsdae_system_get_blocks, nsdae_system_set_mass_blocks, &
            nsdae_system_set_constraint_rows, nsdae_system_set_contacts, nsdae_contact_add, &
            nsdae_row_add, nsdae_force_blocks_fn, nsdae_system_set_force_damping_blocks, &
            nsdae_system_set_force_stiffness_blocks, nsdae_block_add, &
            nsdae_joint_friction_rows_fn, nsdae_system_set_joint_friction_rows
  ! callbacks.list: public_setters
  ! callbacks.list: end

  interface
    ! headers: functions nsdae_system_ create destroy set_user set_contact clear_error simulations set_name
    ! headers: functions nsdae_system_ set_size sensor_size get_name get_unit set_frictional_joint error get_dims
    ! headers: functions nsdae_system_ set_friction_bound set_friction_circle
    ! headers: functions nsdae_system_ differences unseen check set_blocks get_blocks set_mass_blocks
    ! headers: functions nsdae_system_ set_constraint_rows set_joint_friction_rows set_contacts
    ! headers: functions nsdae_system_ set_force_damping_blocks set_force_stiffness_blocks
    ! headers: functions nsdae_ contact_add row_add block_add

    ! callbacks.list: c_setters
    ! callbacks.list: end
  end interface

contains

  ! Creates a system without callbacks. NSDAE_E_ARGUMENT: a size is out of range; NSDAE_E_MEMORY.
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

  ! User pointer of a simulation with its own user, and its deallocation.
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

  ! A system that C made, with C callbacks, as a system of the module; for the other modules.
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

  ! Frees the system; an empty one is allowed. Its simulations remain valid.
  subroutine nsdae_system_destroy(system)
    type(nsdae_system), intent(inout) :: system
    integer(c_int) :: simulations
    simulations = c_simulations(system%handle)
    call c_destroy(system%handle)
    if (associated(system%model) .and. simulations == 0) deallocate (system%model)
    system%model => null()
  end subroutine

  ! Clears the error record and the stored error of a setter.
  subroutine nsdae_system_clear_error(system)
    type(nsdae_system), intent(in) :: system
    call c_clear_error(at(system))
  end subroutine

  ! Number of existing simulations; while there are any, setters return NSDAE_E_STATE.
  integer(c_int) function nsdae_system_simulations(system) result(count)
    type(nsdae_system), intent(in) :: system
    count = c_simulations(system%handle)
  end function

  ! The C handle, for programs in both languages; its user pointer belongs to the module.
  type(c_ptr) function nsdae_system_handle(system) result(handle)
    type(nsdae_system), intent(in) :: system
    handle = system%handle
  end function

  ! The C handle for a new call: clears the refusal of an earlier one.
  type(c_ptr) function at(system) result(handle)
    type(nsdae_system), intent(in) :: system
    handle = system%handle
    if (associated(system%model)) system%model%refusal%status = NSDAE_OK
  end function

  ! Sets the last argument of every callback: a target that outlives the system.
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
  ! headers: wrappers nsdae_system_ set_frictional_joint set_friction_bound set_friction_circle

  ! Sets name and unit of object i (from 0) of a kind, e.g. (system, NSDAE_NAME_COORDINATE, 2,
  ! 'theta', 'rad'). NSDAE_E_ARGUMENT: no such kind or number, name empty or text too long.
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

  ! Number of values of sensor i; 0: there is none.
  integer(c_int) function nsdae_system_sensor_size(system, i) result(number)
    type(nsdae_system), intent(in) :: system
    integer(c_int), intent(in) :: i
    number = c_sensor_size(system%handle, i)
  end function

  ! Name and unit; '' if not set.
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

  ! Error record of the last call on this system.
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

  ! Checks every callback at (t, q [nq], v [nv]); the C header has the details:
  !
  ! - writes outside arrays, missing writes, NaN and infinity
  ! - derivatives against central differences, M against its transpose
  ! - tangential directions
  !
  ! NSDAE_OK; NSDAE_E_DERIVATIVE with the wrong entry in worst; NSDAE_E_CALLBACK, NSDAE_E_NONFINITE,
  ! NSDAE_E_ARGUMENT, NSDAE_E_STATE, NSDAE_E_MEMORY.
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

  ! Setters of the callbacks. Required: mass, force; constraint if m > 0; gap if k > 0; gap_tangent
  ! if nt > 0 and any mu > 0; frictional_joint_tangent if a frictional joint has friction. Others are
  ! replaced by central differences or zero (C header). NSDAE_E_ARGUMENT: the system has no such
  ! term.

  ! callbacks.list: f_setters
  ! callbacks.list: end

  ! Divides q and v into blocks: block b has nq(b + 1) coordinates and nv(b + 1) velocities. The
  ! callback mass_blocks then replaces mass. constraint_rows may replace constraint_jacobian,
  ! joint_friction_rows frictional_joint_tangent, and contacts the callbacks of fixed contacts.
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

  ! Number of blocks: 1 by default.
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

  integer(c_int) function nsdae_system_set_joint_friction_rows(system, joint_friction_rows) &
      result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_joint_friction_rows_fn) :: joint_friction_rows
    status = c_set_joint_friction_rows(at(system), c_funloc(call_joint_friction_rows))
    if (status == NSDAE_OK) system%model%joint_friction_rows => joint_friction_rows
  end function

  integer(c_int) function nsdae_system_set_force_damping_blocks(system, force_damping_blocks) &
      result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_force_blocks_fn) :: force_damping_blocks
    status = c_set_force_damping_blocks(at(system), c_funloc(call_force_damping_blocks))
    if (status == NSDAE_OK) system%model%force_damping_blocks => force_damping_blocks
  end function

  integer(c_int) function nsdae_system_set_force_stiffness_blocks(system, &
      force_stiffness_blocks) result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_force_blocks_fn) :: force_stiffness_blocks
    status = c_set_force_stiffness_blocks(at(system), c_funloc(call_force_stiffness_blocks))
    if (status == NSDAE_OK) system%model%force_stiffness_blocks => force_stiffness_blocks
  end function

  integer(c_int) function nsdae_system_set_contacts(system, contacts) result(status)
    type(nsdae_system), intent(in) :: system
    procedure(nsdae_contacts_fn) :: contacts
    status = c_set_contacts(at(system), c_funloc(call_contacts))
    if (status == NSDAE_OK) system%model%contacts => contacts
  end function

  ! Adds a copy of a contact to the contact list. NSDAE_OK, NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE.
  integer(c_int) function nsdae_contact_add(list, contact) result(status)
    type(nsdae_contact_list), intent(in) :: list
    type(nsdae_contact), intent(in) :: contact
    status = c_contact_add(list%handle, contact)
  end function

  ! Adds the entries values [nv of the block] of row 0 <= row < m in a block (from 0). Rows must be
  ! in ascending order, each block once per row.
  integer(c_int) function nsdae_row_add(rows, row, block, values) result(status)
    type(nsdae_row_list), intent(in) :: rows
    integer(c_int), intent(in) :: row, block
    real(c_double), intent(in), contiguous :: values(:)
    status = c_row_add(rows%handle, row, block, values)
  end function

  ! Adds values [nv of row, nv of column] to the block (row, column), from 0, of D or K; repeated
  ! blocks are summed.
  integer(c_int) function nsdae_block_add(blocks, row, column, values) result(status)
    type(nsdae_block_list), intent(in) :: blocks
    integer(c_int), intent(in) :: row, column
    real(c_double), intent(in), contiguous :: values(:, :)
    status = c_block_add(blocks%handle, row, column, values)
  end function

  ! The callbacks of C: each calls the user's procedure with shaped arrays, without copies.

  function model_at(p) result(here)
    type(c_ptr), intent(in) :: p
    type(model), pointer :: here
    call c_f_pointer(p, here)
  end function

  ! An array that is NULL if it is empty.
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

  integer(c_int) function call_joint_friction_rows(t, q, rows, w_s, user) &
      result(status) bind(C, name='')
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*)
    type(c_ptr), value :: rows, user
    real(c_double), intent(inout) :: w_s(*)
    type(model), pointer :: here
    type(nsdae_row_list) :: list
    here => model_at(user)
    list%handle = rows
    associate (d => here%dims)
      status = here%joint_friction_rows(t, q(:d%nq), list, w_s(:d%f), here%user)
    end associate
  end function

  integer(c_int) function call_force_damping_blocks(t, q, v, blocks, user) &
      result(status) bind(C, name='')
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*), v(*)
    type(c_ptr), value :: blocks, user
    type(model), pointer :: here
    type(nsdae_block_list) :: list
    here => model_at(user)
    list%handle = blocks
    associate (d => here%dims)
      status = here%force_damping_blocks(t, q(:d%nq), v(:d%nv), list, here%user)
    end associate
  end function

  integer(c_int) function call_force_stiffness_blocks(t, q, v, blocks, user) &
      result(status) bind(C, name='')
    real(c_double), value :: t
    real(c_double), intent(in) :: q(*), v(*)
    type(c_ptr), value :: blocks, user
    type(model), pointer :: here
    type(nsdae_block_list) :: list
    here => model_at(user)
    list%handle = blocks
    associate (d => here%dims)
      status = here%force_stiffness_blocks(t, q(:d%nq), v(:d%nv), list, here%user)
    end associate
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
