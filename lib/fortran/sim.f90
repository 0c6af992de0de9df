! nsdae/sim.h: time integration of a system.
module nsdae_f_sim
  use, intrinsic :: iso_c_binding
  use nsdae_f_friction
  use nsdae_f_lcp
  use nsdae_f_params
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_text
  implicit none
  private

  ! options%method; their names are those of nsdae_method_name.
  ! headers: constants NSDAE_METHOD_

  ! Linear solvers of the integrator of event.
  ! headers: constants NSDAE_INTEGRATOR_

  ! What to do where Phi_q has deficient rank.
  ! headers: constants NSDAE_REDUNDANT_

  ! What the end of a step of a time-stepping method is moved to.
  ! headers: constants NSDAE_PROJECTION_

  ! Modes of a contact or frictional joint.
  ! headers: constants NSDAE_MODE_

  ! Normal force of penalty.
  ! headers: constants NSDAE_PENALTY_

  ! headers: constants NSDAE_OBSERVERS_MAX NSDAE_VALUES_MAX

  ! Initialise with nsdae_sim_options_default; an uninitialised variable is an error.
  type, bind(C), public :: nsdae_sim_options
    integer(c_int) :: method
    real(c_double) :: dt                                ! step [s]
    real(c_double) :: baumgarte_alpha, baumgarte_beta   ! Baumgarte stabilisation in smooth phases [1/s]
    real(c_double) :: iteration_tol                     ! relative change that ends an iteration
    integer(c_int) :: iteration_max
    integer(c_int) :: redundant
    real(c_double) :: rank_tol
    real(c_double) :: contact_tol
    real(c_double) :: contact_work                      ! multiplications by J for an island; 0: see nsdae/sim.h
    real(c_double) :: contact_give                      ! a step goes on up to this times contact_tol, see nsdae/sim.h
    integer(c_int) :: polygon                           ! edges for nt = 2: 3 .. 32; 0: second-order cone
    real(c_double) :: impact_velocity                   ! a slower closing is no impact [m/s]
    real(c_double) :: rtol, atol                        ! of the integrator of penalty and event
    integer(c_int) :: penalty_law
    real(c_double) :: penalty_stiffness                 ! K [N/m^n]
    real(c_double) :: penalty_exponent                  ! n
    real(c_double) :: friction_velocity                 ! regularisation in penalty [m/s]
    integer(c_int) :: integrator                        ! of penalty and event: NSDAE_INTEGRATOR_AUTO and so on
    real(c_double) :: step_max                          ! largest step of the integrator [s]
    real(c_double) :: accumulation_time                 ! event closes shorter accumulations [s]
    integer(c_int) :: events_max                        ! of event in one dt
    integer(c_int) :: projection                        ! NSDAE_PROJECTION_NONE and so on
    real(c_double) :: start_tol                         ! relative tolerance of initial conditions
    integer(c_int) :: inner_steps_max                ! of the integrator in one dt
    integer(c_int) :: start_check                       ! 1: check callbacks for gross errors
    integer(c_int) :: contacts_max                      ! maximum number in a contact list
    integer(c_int) :: threads                           ! threads of a step
    integer(c_int) :: initialised = 0                   ! set by nsdae_sim_options_default
  end type

  ! An impact of one contact: at one time (event-driven) or in one step (time stepping).
  type, bind(C), public :: nsdae_impact
    real(c_double) :: time                              ! [s]
    integer(c_int) :: contact                           ! index into the record's contacts, from 0
    real(c_double) :: normal_impulse                    ! [N s]
    real(c_double) :: tangential_impulse(2)
    real(c_double) :: velocity_before, velocity_after   ! normal velocity [m/s]
    real(c_double) :: peak_force                        ! [N]; 0 for a rigid contact
    integer(c_int) :: accumulation                      ! 1: infinitely many (Zeno), at rest after time
    integer(c_long) :: id                               ! of the contact; fixed contacts: its number, from 0
    integer(c_int) :: block(2)                          ! of a listed contact, -1: the ground; fixed contacts: -1
  end type

  ! A mode transition of a contact or frictional joint; method event only.
  type, bind(C), public :: nsdae_change
    real(c_double) :: time                              ! [s]
    integer(c_int) :: contact                           ! as in nsdae_impact; -1: a frictional joint
    integer(c_int) :: frictional_joint                  ! from 0; -1: a contact
    integer(c_int) :: mode_before, mode_after           ! NSDAE_MODE_OPEN, NSDAE_MODE_SLIP, NSDAE_MODE_STICK
    integer(c_long) :: id                               ! as in nsdae_impact; -1: a frictional joint
    integer(c_int) :: block(2)                          ! as in nsdae_impact
  end type

  ! Contacts of a step: all fixed contacts in their order, id = 0, 1, ...; or those of the contact
  ! list that were closed in the step. block(:, i) of contact i are numbered from 0; -1: the ground,
  ! and of fixed contacts.
  type, public :: nsdae_contact_set
    integer(c_int) :: count = 0                                    ! fixed contacts: k
    integer(c_long), pointer :: id(:) => null()
    integer(c_int), pointer :: block(:, :) => null()                ! [2, count]
    real(c_double), pointer :: gap(:) => null()                    ! [count] at the last evaluation
    real(c_double), pointer :: normal_impulse(:) => null()         ! [count] over the step
    real(c_double), pointer :: tangential_impulse(:, :) => null()  ! [nt, count]
    integer(c_int), pointer :: mode(:) => null()
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_contact_set

  ! Violation of the laws by a step. Each value has the contact or constraint of its maximum: from 0
  ! (contact list: index into the record's contacts), -1 if the value is 0. The energies satisfy
  ! energy = energy_start + work - dissipated + unexplained.
  type, bind(C), public :: nsdae_certificate
    real(c_double) :: pull = 0               ! max(0, -Lambda_N) [N s]
    real(c_double) :: cone_excess = 0        ! max(0, |Lambda_T| - mu Lambda_N) [N s]
    real(c_double) :: penetration = 0        ! max(0, -g_N) [m]
    real(c_double) :: constraint_drift = 0   ! max |Phi|
    real(c_double) :: constraint_rate = 0    ! max |dPhi/dt|
    real(c_double) :: complementarity = 0    ! max |Lambda_N xi_N| [J]
    real(c_double) :: energy = 0             ! kinetic + potential [J]
    real(c_double) :: work = 0               ! of forces without potential, moving constraints and moving contacts [J]
    real(c_double) :: dissipated = 0         ! by contact and friction impulses [J]
    real(c_double) :: unexplained = 0        ! numerical energy [J]: < 0: loss, > 0: gain
    integer(c_int) :: pull_contact = -1, cone_contact = -1, penetration_contact = -1
    integer(c_int) :: drift_constraint = -1, rate_constraint = -1
    integer(c_int) :: complementarity_contact = -1
  end type

  ! The state after a step (step = 0: at the start) and its certificate. The arrays belong to the
  ! simulation, are valid until the next step, and must not be changed.
  type, public :: nsdae_record
    integer(c_long) :: step = 0
    real(c_double) :: time = 0
    real(c_double) :: duration = 0                              ! of the step [s]
    real(c_double), pointer :: q(:) => null(), v(:) => null()
    real(c_double), pointer :: acceleration(:) => null()        ! [nv] mean over the step
    real(c_double), pointer :: multiplier(:) => null()          ! [m] mean bilateral force
    real(c_double), pointer :: gap(:) => null()                 ! [k], as the next ones; contact list: null
    real(c_double), pointer :: normal_impulse(:) => null()      ! [k] over the step
    real(c_double), pointer :: tangential_impulse(:, :) => null()  ! [nt, k]
    real(c_double), pointer :: normal_force(:) => null()        ! [k] mean over the step [N]
    real(c_double), pointer :: tangential_force(:, :) => null()    ! [nt, k]
    integer(c_int), pointer :: mode(:) => null()                ! [k]
    real(c_double), pointer :: frictional_joint_impulse(:) => null()       ! [f]
    real(c_double), pointer :: frictional_joint_force(:) => null()         ! [f] its mean force
    integer(c_int), pointer :: frictional_joint_mode(:) => null()          ! [f]
    type(nsdae_contact_set) :: contacts                         ! of the step, fixed or listed
    real(c_double) :: kinetic = 0, potential = 0                ! [J]
    real(c_double) :: dissipated = 0     ! work absorbed by all contact impulses since the start [J]
    real(c_double) :: projection_energy = 0  ! part of it: potential energy added by projection = slop [J]
    real(c_double) :: lcp_residual = 0   ! scaled natural residual
    real(c_double) :: contact_tol = 0    ! largest tolerance of the contact problems; 0: none
    real(c_double) :: constraint_drift = 0                      ! max |Phi|
    real(c_double) :: penetration = 0                           ! max(0, -g_N)
    type(nsdae_impact), pointer :: impact(:) => null()          ! [impacts]
    integer(c_int) :: impacts = 0
    type(nsdae_change), pointer :: change(:) => null()          ! [changes]
    integer(c_int) :: changes = 0
    type(nsdae_certificate) :: certificate
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_record

  type, bind(C), public :: nsdae_stats
    integer(c_long) :: steps, smooth_steps, contact_steps
    integer(c_long) :: lcps, lcp_pivots, iterations
    integer(c_long) :: mass_evals, force_evals, jacobian_evals
    integer(c_long) :: impacts
    integer(c_long) :: events, accumulations  ! method event: events; closed accumulations
    integer(c_long) :: fallback_steps    ! method event: dt taken by implicit instead
    integer(c_long) :: inexact_steps     ! an island had a residual above its tolerance
    integer(c_long) :: frozen_steps      ! implicit: contacts frozen in the step
    integer(c_long) :: accumulations_early  ! closed before accumulation_time
    real(c_double) :: rank_retained, rank_discarded  ! sines: smallest of retained, largest of discarded rows
    integer(c_int) :: rank, rank_most    ! smallest and largest rank of Phi_q
    real(c_double) :: worst_residual     ! of all contact problems
    real(c_double) :: contact_tol        ! the largest tolerance of them; 0: there was none
    real(c_double) :: worst_drift
    real(c_double) :: worst_penetration
    real(c_double) :: energy_start       ! kinetic + potential at the start [J]
    real(c_double) :: energy_balance     ! energy + dissipated - energy_start [J]
    integer(c_int) :: warnings           ! 1: energy, 2: penetration, 4: drift, 8: Painleve, 16: impacts, 32: restitution,
                                         ! 64: contact, 128: singular
    real(c_double) :: wall_time          ! in nsdae_sim_run and nsdae_sim_step [s]
    integer(c_int) :: contact_capacity   ! capacity of the contact list; it grows between steps
    integer(c_int) :: contact_growths    ! number of growths
    integer(c_int) :: islands            ! islands of the last step
    integer(c_int) :: island_contacts    ! contacts of the largest island
    type(nsdae_certificate) :: certificate  ! maxima over all records; energies of the last
  end type

  abstract interface
    ! Called with every record. 0: continue; > 0: stop after it (NSDAE_STOPPED); < 0: the run fails
    ! with this status, and with error if its status was set.
    integer(c_int) function nsdae_observer_fn(record, error, user)
      import
      type(nsdae_record), intent(in) :: record
      type(nsdae_error), intent(inout) :: error
      class(*), intent(inout) :: user
    end function
  end interface

  abstract interface
    ! Interrupt function; a value other than 0 ends the current step.
    integer(c_int) function nsdae_interrupt_fn(user)
      import
      class(*), intent(inout) :: user
    end function
  end interface

  ! An observer: the user pointer of call_observer.
  type :: observation
    procedure(nsdae_observer_fn), pointer, nopass :: call => null()
    class(*), pointer :: user => null()
    type(nsdae_dims) :: dims
  end type

  type :: run
    type(nsdae_dims) :: dims
    type(observation) :: observer(NSDAE_OBSERVERS_MAX)
    class(*), pointer :: model => null()  ! with a user of its own, see nsdae_sim_set_user
    procedure(nsdae_interrupt_fn), pointer, nopass :: asked => null()
    class(*), pointer :: asked_user => null()
    type(nsdae_error) :: refusal  ! error of the module in the last call; C has the others
  end type

  ! A simulation; empty before nsdae_sim_create. Copies refer to the same simulation.
  type, public :: nsdae_sim
    private
    type(c_ptr) :: handle = c_null_ptr
    type(run), pointer :: run => null()
    type(nsdae_system) :: system
  end type

  ! The contact problem of a step: options of its solve, initial guess, resulting r and u.
  type, public :: nsdae_step_friction
    type(nsdae_friction_problem) :: problem
    type(nsdae_friction_options) :: options
    real(c_double), pointer, contiguous :: guess(:) => null(), r(:) => null(), u(:) => null()
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_step_friction

  public :: nsdae_observer_fn, nsdae_interrupt_fn, nsdae_sim_set_interrupt
  public :: nsdae_sim_options_default, nsdae_sim_options_set, nsdae_sim_options_table, &
            nsdae_method_name, nsdae_method_summary, nsdae_sim_create, nsdae_sim_destroy, &
            nsdae_sim_project, nsdae_sim_init, nsdae_sim_observe, nsdae_sim_unobserve, nsdae_sim_step, &
            nsdae_sim_run, nsdae_sim_get_record, nsdae_sim_get_stats, nsdae_sim_get_dims, &
            nsdae_sim_has_potential, nsdae_sim_get_options, nsdae_sim_get_failed_lcp, &
            nsdae_sim_get_friction, &
            nsdae_sim_error, nsdae_sim_handle, nsdae_sim_get_system, nsdae_sim_state_size, &
            nsdae_sim_get_state, nsdae_sim_set_state, nsdae_sim_run_to_event, &
            nsdae_sim_interpolate, nsdae_sim_set_user, nsdae_sim_set_options, &
            nsdae_sim_set_contact, nsdae_sim_set_frictional_joint, nsdae_sim_set_friction_bound, &
            nsdae_sim_set_control, nsdae_sim_get_control, nsdae_sim_get_sensor, &
            nsdae_sim_get_contact_forces

  interface
    subroutine nsdae_sim_options_default(options) bind(C)
      import
      type(nsdae_sim_options), intent(inout) :: options
    end subroutine

    ! headers: functions nsdae_sim_ options_set options_table create destroy project init observe
    ! headers: functions nsdae_sim_ set_interrupt unobserve step run get_record get_stats run_to_event
    ! headers: functions nsdae_sim_ interpolate set_user set_options set_contact set_frictional_joint
    ! headers: functions nsdae_sim_ set_friction_bound set_control get_control get_sensor get_contact_forces
    ! headers: functions nsdae_sim_ state_size get_state set_state get_dims has_potential get_options
    ! headers: functions nsdae_sim_ get_failed_lcp get_friction error
    ! headers: functions nsdae_ method_name method_summary
  end interface

contains

  ! Sets one option from text, e.g. ("dt", "0.005") or ("method", "moreau"). NSDAE_E_OPTION: no such
  ! key or choice (the text suggests the nearest); NSDAE_E_ARGUMENT: out of range.
  integer(c_int) function nsdae_sim_options_set(options, key, val, error) result(status)
    type(nsdae_sim_options), intent(inout) :: options
    character(len=*), intent(in) :: key, val
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_key(len_trim(key) + 1), c_val(len_trim(val) + 1)
    type(nsdae_c_error) :: why
    call to_chars(key, c_key)
    call to_chars(val, c_val)
    status = c_options_set(options, c_key, c_val, why)
    call error_from_c(why, error)
  end function

  ! The table of the options, over this variable: keys, units, ranges, defaults.
  type(nsdae_params) function nsdae_sim_options_table(options) result(table)
    type(nsdae_sim_options), pointer, intent(in) :: options
    table = table_at(c_options_table(), c_loc(options))
  end function

  ! Name of a method and what it is, in one line; '' past the last.
  ! headers: wrappers nsdae_ method_name method_summary

  ! Creates a simulation and allocates its memory. The system must be complete and outlive it;
  ! without options, the defaults. NSDAE_E_ARGUMENT, NSDAE_E_STATE (a required callback is missing),
  ! NSDAE_E_MEMORY.
  integer(c_int) function nsdae_sim_create(system, sim, options, error) result(status)
    type(nsdae_system), intent(in) :: system
    type(nsdae_sim), intent(out) :: sim
    type(nsdae_sim_options), intent(in), optional :: options
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    integer :: failed
    status = c_create(nsdae_system_handle(system), options, sim%handle, why)
    call error_from_c(why, error)
    if (status < 0) return
    allocate (sim%run, stat=failed)
    if (failed /= 0) then
      call c_destroy(sim%handle)
      status = no_memory('nsdae_sim_create', error)
      return
    end if
    sim%system = system
    status = c_get_dims(sim%handle, sim%run%dims)
  end function

  ! Frees the simulation; an empty one is allowed. During another call on it, nothing is freed.
  subroutine nsdae_sim_destroy(sim)
    type(nsdae_sim), intent(inout) :: sim
    call c_destroy(sim%handle)
    if (c_associated(sim%handle)) return
    if (.not. associated(sim%run)) return
    if (associated(sim%run%model)) deallocate (sim%run%model)
    deallocate (sim%run)
  end subroutine

  ! The C handle, for programs in both languages.
  type(c_ptr) function nsdae_sim_handle(sim) result(handle)
    type(nsdae_sim), intent(in) :: sim
    handle = sim%handle
  end function

  ! The C handle for a new call: clears the refusal of an earlier one.
  type(c_ptr) function at(sim) result(handle)
    type(nsdae_sim), intent(in) :: sim
    handle = sim%handle
    if (associated(sim%run)) sim%run%refusal%status = NSDAE_OK
  end function

  ! Makes initial conditions q0 [nq] and v0 [nv] consistent, by the least change in the metric of M:
  ! constraints, unit lengths and g_N >= 0. The state of the simulation is unchanged.
  ! NSDAE_E_CONVERGENCE: no consistent state nearby.
  integer(c_int) function nsdae_sim_project(sim, t0, q0, v0) result(status)
    type(nsdae_sim), intent(in) :: sim
    real(c_double), intent(in) :: t0
    real(c_double), intent(inout), contiguous :: q0(:), v0(:)
    if (associated(sim%run)) then
      status = check_state(sim%run%dims, 'q0', q0, 'v0', v0, sim%run%refusal)
      if (status < 0) return
    end if
    status = c_project(at(sim), t0, q0, v0)
  end function

  ! Starts at t0 with q0 [nq], v0 [nv]; evaluates every term once. May be called again. Initial
  ! conditions must satisfy constraints, their rates, unit lengths and (event) gaps, to the
  ! tolerance start_tol: NSDAE_E_ARGUMENT names the row, its value and the bound. event moves an
  ! overlap within start_tol to gap 0. Time stepping keeps any overlap; beyond start_tol its first
  ! step returns NSDAE_WARN_PENETRATION.
  integer(c_int) function nsdae_sim_init(sim, t0, q0, v0) result(status)
    type(nsdae_sim), intent(in) :: sim
    real(c_double), intent(in) :: t0
    real(c_double), intent(in), contiguous :: q0(:), v0(:)
    if (associated(sim%run)) then
      status = check_state(sim%run%dims, 'q0', q0, 'v0', v0, sim%run%refusal)
      if (status < 0) return
    end if
    status = c_init(at(sim), t0, q0, v0)
  end function

  ! Adds an observer, at most NSDAE_OBSERVERS_MAX; observers are called in the order of these calls.
  ! user is a target that outlives the simulation.
  integer(c_int) function nsdae_sim_observe(sim, observer, user) result(status)
    type(nsdae_sim), intent(in) :: sim
    procedure(nsdae_observer_fn) :: observer
    class(*), target, intent(inout), optional :: user
    type(observation), pointer :: slot
    type(c_ptr) :: place
    slot => null()
    place = c_null_ptr
    if (associated(sim%run)) slot => free_slot(sim%run)
    if (associated(slot)) then
      slot%call => observer
      slot%user => chosen(user)
      slot%dims = sim%run%dims
      place = c_loc(slot)
    end if
    ! without a slot: too many, the C function returns the error
    status = c_observe(at(sim), c_funloc(call_observer), place)
    if (status < 0 .and. associated(slot)) slot%call => null()
  end function

  ! Removes the observer that was added with these arguments; no error if there is none.
  integer(c_int) function nsdae_sim_unobserve(sim, observer, user) result(status)
    type(nsdae_sim), intent(in) :: sim
    procedure(nsdae_observer_fn) :: observer
    class(*), target, intent(inout), optional :: user
    type(observation), pointer :: slot
    integer :: i
    status = NSDAE_E_ARGUMENT
    if (.not. associated(sim%run)) return
    status = NSDAE_OK
    do i = 1, NSDAE_OBSERVERS_MAX
      slot => sim%run%observer(i)
      if (.not. associated(slot%call, observer)) cycle
      if (.not. same(slot%user, chosen(user))) cycle
      status = c_unobserve(at(sim), c_funloc(call_observer), c_loc(slot))
      if (status == NSDAE_OK) slot%call => null()
      return
    end do
  end function

  function free_slot(this) result(slot)
    type(run), target, intent(inout) :: this
    type(observation), pointer :: slot
    integer :: i
    do i = 1, NSDAE_OBSERVERS_MAX
      slot => this%observer(i)
      if (.not. associated(slot%call)) return
    end do
    slot => null()
  end function

  function chosen(user)
    class(*), target, intent(inout), optional :: user
    class(*), pointer :: chosen
    chosen => no_user
    if (present(user)) chosen => user
  end function

  logical function same(a, b)
    class(*), pointer, intent(in) :: a, b
    same = associated(a, b)
  end function

  ! One step of dt. NSDAE_OK; NSDAE_EVENT when there was an impact in it; NSDAE_STOPPED; < 0: the
  ! step was not done and the state is the one before it.
  ! headers: wrappers nsdae_sim_ step

  ! Steps of dt from the start's time to t_end; the last one is shortened to end there.
  ! headers: wrappers nsdae_sim_ run

  ! The same, but back after the first step with NSDAE_EVENT or NSDAE_ZENO, with that status.
  ! headers: wrappers nsdae_sim_ run_to_event

  ! q [nq] and v [nv] at a time of the last step, including its ends. NSDAE_E_ARGUMENT: t is outside
  ! the last step; NSDAE_E_STATE: there is no last step.
  integer(c_int) function nsdae_sim_interpolate(sim, t, q, v) result(status)
    type(nsdae_sim), intent(in) :: sim
    real(c_double), intent(in) :: t
    real(c_double), intent(inout), contiguous :: q(:), v(:)
    if (associated(sim%run)) then
      status = check_state(sim%run%dims, 'q', q, 'v', v, sim%run%refusal)
      if (status < 0) return
    end if
    status = c_interpolate(at(sim), t, q, v)
  end function

  ! Sets the last argument of the callbacks in this simulation, in place of the system's: a target
  ! that outlives the simulation.
  integer(c_int) function nsdae_sim_set_user(sim, user) result(status)
    type(nsdae_sim), intent(in) :: sim
    class(*), target, intent(inout) :: user
    class(*), pointer :: own
    type(c_ptr) :: place
    status = NSDAE_E_ARGUMENT
    if (.not. associated(sim%run)) return
    call nsdae_system_for_user(sim%system, user, place, own)
    status = NSDAE_E_MEMORY
    if (.not. associated(own)) return
    status = c_set_user(at(sim), place)
    if (status == NSDAE_OK) then
      if (associated(sim%run%model)) deallocate (sim%run%model)
      sim%run%model => own
    else
      deallocate (own)
    end if
  end function

  ! Other options from here on; method, polygon, projection and threads are fixed: NSDAE_E_ARGUMENT.
  ! headers: wrappers nsdae_sim_ set_options

  ! Coefficients of contact i and of frictional joint j in this simulation, in place of the system's.
  ! headers: wrappers nsdae_sim_ set_contact set_frictional_joint set_friction_bound

  ! The target of motor i in this simulation, in place of the constant one.
  ! headers: wrappers nsdae_sim_ set_control
  integer(c_int) function nsdae_sim_get_control(sim, i, val) result(status)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int), intent(in) :: i
    real(c_double), intent(out) :: val
    real(c_double) :: is(1)
    is = 0
    status = c_get_control(at(sim), i, is)
    val = is(1)
  end function

  ! The values of sensor i at the present record, val(1:nsdae_system_sensor_size(system, i)).
  integer(c_int) function nsdae_sim_get_sensor(sim, i, val) result(status)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int), intent(in) :: i
    real(c_double), intent(out) :: val(NSDAE_VALUES_MAX)
    val = 0
    status = c_get_sensor(at(sim), i, val)
  end function

  ! Points and forces (3, count) of the contacts of the present record, allocated here. The point of
  ! a contact of two solids is midway between their surfaces; the force is on the body of the larger
  ! number, a mean over the step. A contact without an impulse, a limit, a rope and a contact of user
  ! rows have the point NaN and the force 0.
  integer(c_int) function nsdae_sim_get_contact_forces(sim, point, force) result(status)
    type(nsdae_sim), intent(in) :: sim
    real(c_double), allocatable, intent(out) :: point(:, :), force(:, :)
    type(nsdae_record) :: record
    integer :: lost
    status = nsdae_sim_get_record(sim, record)
    if (status < 0) return
    allocate (point(3, record%contacts%count), force(3, record%contacts%count), stat=lost)
    if (lost == 0) then
      status = c_get_contact_forces(at(sim), point, force)
    else
      if (allocated(point)) deallocate (point)
      status = NSDAE_E_MEMORY
    end if
  end function

  ! Size in bytes of the state block, which depends on system and options. A block contains all data
  ! that the next step depends on. A simulation of the same system and options continues from it
  ! byte for byte like the original run.
  integer(c_int) function nsdae_sim_state_size(sim, bytes) result(status)
    type(nsdae_sim), intent(in) :: sim
    integer(c_size_t), intent(out) :: bytes
    bytes = 0
    status = c_state_size(at(sim), bytes)
  end function

  ! Copies the state into a block. In an observer it is the state after the record.
  integer(c_int) function nsdae_sim_get_state(sim, block) result(status)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int8_t), intent(inout), contiguous :: block(:)
    status = c_get_state(at(sim), block, size(block, kind=c_size_t))
  end function

  ! Sets the state from a block; observers are not called for it. NSDAE_E_ARGUMENT: damaged or not a
  ! block, or of another system, method or options; the text names the difference. The state is then
  ! unchanged.
  integer(c_int) function nsdae_sim_set_state(sim, block) result(status)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int8_t), intent(in), contiguous :: block(:)
    status = c_set_state(at(sim), block, size(block, kind=c_size_t))
  end function

  ! The last record; NSDAE_E_STATE before nsdae_sim_init.
  integer(c_int) function nsdae_sim_get_record(sim, record) result(status)
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_record), intent(out) :: record
    type(nsdae_c_record) :: from
    status = c_get_record(at(sim), from)
    if (status >= 0) call shape_record(from, sim%run%dims, record)
  end function

  ! headers: wrappers nsdae_sim_ get_stats get_dims

  ! Whether the system has a callback for the potential energy.
  logical function nsdae_sim_has_potential(sim)
    type(nsdae_sim), intent(in) :: sim
    nsdae_sim_has_potential = c_has_potential(sim%handle) /= 0
  end function

  ! headers: wrappers nsdae_sim_ get_options

  ! The complementarity problem of a step that failed with NSDAE_E_LCP, NSDAE_E_INFEASIBLE or
  ! NSDAE_E_PAINLEVE. Its arrays belong to the simulation and are valid until the next step.
  ! NSDAE_E_STATE: the last step did not fail in this way.
  integer(c_int) function nsdae_sim_get_failed_lcp(sim, A, b) result(status)
    type(nsdae_sim), intent(in) :: sim
    real(c_double), pointer, intent(out) :: A(:, :), b(:)
    type(nsdae_c_lcp_problem) :: problem
    A => null()
    b => null()
    status = c_get_failed_lcp(sim%handle, problem)
    if (status == NSDAE_OK) call shape_problem(problem, A, b)
  end function

  ! The contact problem of the last step of a time-stepping method, with the options of its solve,
  ! its initial guess and its result. The arrays belong to the simulation and are valid until the
  ! next step. NSDAE_E_STATE: the last step had none.
  integer(c_int) function nsdae_sim_get_friction(sim, friction) result(status)
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_step_friction), intent(out) :: friction
    type(nsdae_c_step_friction) :: c
    integer :: m
    status = c_get_friction(sim%handle, c)
    if (status /= NSDAE_OK) return
    call problem_from_c(c%problem, friction%problem)
    friction%options = c%options
    m = rows_of_problem(friction%problem)
    call c_f_pointer(c%guess, friction%guess, [m])
    call c_f_pointer(c%r, friction%r, [m])
    call c_f_pointer(c%u, friction%u, [m])
  end function

  ! The system of the simulation.
  type(nsdae_system) function nsdae_sim_get_system(sim) result(system)
    type(nsdae_sim), intent(in) :: sim
    system = sim%system
  end function

  ! Error record of the last call on this simulation.
  type(nsdae_error) function nsdae_sim_error(sim) result(error)
    type(nsdae_sim), intent(in) :: sim
    if (associated(sim%run)) then
      error = sim%run%refusal
      if (error%status /= NSDAE_OK) return
    end if
    error = error_at(c_error(sim%handle))
  end function

  ! The functions that C calls.
  integer(c_int) function call_interrupt(user) result(code) bind(C, name='')
    type(c_ptr), value :: user
    type(run), pointer :: here
    call c_f_pointer(user, here)
    code = here%asked(here%asked_user)
  end function

  ! Sets the interrupt function; without asked: none. It is called before every step, and after
  ! every internal step of penalty and event. An interrupted step returns NSDAE_E_INTERRUPTED; the
  ! state is the one before it.
  integer(c_int) function nsdae_sim_set_interrupt(sim, asked, user) result(status)
    type(nsdae_sim), intent(in) :: sim
    procedure(nsdae_interrupt_fn), optional :: asked
    class(*), target, intent(inout), optional :: user
    type(c_funptr) :: call_back
    status = NSDAE_E_ARGUMENT
    if (.not. associated(sim%run)) return
    call_back = c_null_funptr
    if (present(asked)) call_back = c_funloc(call_interrupt)
    status = c_set_interrupt(at(sim), call_back, c_loc(sim%run))
    if (status < 0 .or. .not. present(asked)) return
    sim%run%asked => asked
    sim%run%asked_user => chosen(user)
  end function

  integer(c_int) function call_observer(from, error, user) result(status) bind(C, name='')
    type(nsdae_c_record), intent(in) :: from
    type(nsdae_c_error), intent(inout) :: error
    type(c_ptr), value :: user
    type(observation), pointer :: here
    type(nsdae_record) :: record
    type(nsdae_error) :: why
    call c_f_pointer(user, here)
    call shape_record(from, here%dims, record)
    status = here%call(record, why, here%user)
    if (why%status /= NSDAE_OK) call error_to_c(why, error)
  end function

  ! The arrays of the C record with their shapes; nothing is copied.
  subroutine shape_record(from, dims, record)
    type(nsdae_c_record), intent(in) :: from
    type(nsdae_dims), intent(in) :: dims
    type(nsdae_record), intent(inout) :: record
    record%step = from%step
    record%time = from%time
    record%duration = from%duration
    call c_f_pointer(from%q, record%q, [dims%nq])
    call c_f_pointer(from%v, record%v, [dims%nv])
    call c_f_pointer(from%acceleration, record%acceleration, [dims%nv])
    call c_f_pointer(from%multiplier, record%multiplier, [dims%m])
    nullify (record%gap, record%normal_impulse, record%tangential_impulse, record%normal_force, &
             record%tangential_force, record%mode)
    if (c_associated(from%gap)) call shape_fixed(from, dims, record)
    call c_f_pointer(from%frictional_joint_impulse, record%frictional_joint_impulse, [dims%f])
    call c_f_pointer(from%frictional_joint_force, record%frictional_joint_force, [dims%f])
    call c_f_pointer(from%frictional_joint_mode, record%frictional_joint_mode, [dims%f])
    call shape_contacts(from%contacts, dims%nt, record%contacts)
    record%kinetic = from%kinetic
    record%potential = from%potential
    record%dissipated = from%dissipated
    record%projection_energy = from%projection_energy
    record%lcp_residual = from%lcp_residual
    record%contact_tol = from%contact_tol
    record%constraint_drift = from%constraint_drift
    record%penetration = from%penetration
    call c_f_pointer(from%impact, record%impact, [from%impacts])
    record%impacts = from%impacts
    call c_f_pointer(from%change, record%change, [from%changes])
    record%changes = from%changes
    record%certificate = from%certificate
  end subroutine

  subroutine shape_fixed(from, dims, record)
    type(nsdae_c_record), intent(in) :: from
    type(nsdae_dims), intent(in) :: dims
    type(nsdae_record), intent(inout) :: record
    call c_f_pointer(from%gap, record%gap, [dims%k])
    call c_f_pointer(from%normal_impulse, record%normal_impulse, [dims%k])
    call c_f_pointer(from%tangential_impulse, record%tangential_impulse, [dims%nt, dims%k])
    call c_f_pointer(from%normal_force, record%normal_force, [dims%k])
    call c_f_pointer(from%tangential_force, record%tangential_force, [dims%nt, dims%k])
    call c_f_pointer(from%mode, record%mode, [dims%k])
  end subroutine

  subroutine shape_contacts(from, nt, contacts)
    type(nsdae_c_contact_set), intent(in) :: from
    integer(c_int), intent(in) :: nt
    type(nsdae_contact_set), intent(inout) :: contacts
    contacts%count = from%count
    call c_f_pointer(from%id, contacts%id, [from%count])
    call c_f_pointer(from%block, contacts%block, [2_c_int, from%count])
    call c_f_pointer(from%gap, contacts%gap, [from%count])
    call c_f_pointer(from%normal_impulse, contacts%normal_impulse, [from%count])
    call c_f_pointer(from%tangential_impulse, contacts%tangential_impulse, [nt, from%count])
    call c_f_pointer(from%mode, contacts%mode, [from%count])
  end subroutine

end module
