/* One machine on omni or mecanum wheels, as native code: @TITLE@

   SI units, rad. Inputs and outputs are known by name, units and what they mean with them. Functions may run in several
   threads at once, each on a machine of its own; none keeps anything beside its machines, and none prints. */

#ifndef omnisim_HEADER
#define omnisim_HEADER

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef omnisim_API
#define omnisim_API __attribute__((visibility("default")))
#endif

typedef struct omnisim_machine omnisim_machine;

typedef enum {
    omnisim_RUNNING, /* done; the machine goes on */
    omnisim_STOPPED, /* something has stopped the machine, for good: omnisim_message says what, when and where */
    omnisim_REFUSED  /* an argument that cannot be meant, omnisim_message says why; nothing has changed */
} omnisim_status;

typedef struct {
    const char *name, *unit, *description;
    double start;       /* of an input: what the scene gives it at the beginning; of a parameter: its value there */
    int whole;          /* 1: a whole number */
    double least, most; /* of a parameter */
} omnisim_variable;

/* A machine at the start of its scene; NULL if there is no memory for it. */
omnisim_API omnisim_machine *omnisim_open(void);
omnisim_API void omnisim_close(omnisim_machine *machine);

/* Back to the start, as just opened: nothing set, parameters as the scene has them. */
omnisim_API omnisim_status omnisim_reset(omnisim_machine *machine);

/* Back to the start with a parameter at this value, others as they were set. */
omnisim_API omnisim_status omnisim_set_parameter(omnisim_machine *machine, int parameter, double value);
omnisim_API double omnisim_get_parameter(const omnisim_machine *machine, int parameter);

/* March on by a multiple of omnisim_grid(), s. There is no end: tables of the scene keep their last values. */
omnisim_API omnisim_status omnisim_step(omnisim_machine *machine, double seconds);

/* The time.step of the scene, s, and its time.end, s, after which nothing changes but that omnisim run would end. */
omnisim_API double omnisim_grid(void);
omnisim_API double omnisim_end(void);

/* s since the start. */
omnisim_API double omnisim_time(const omnisim_machine *machine);

/* Variables count from 0; find returns -1 for a name that there is not, the others NULL for a number too large. */
omnisim_API int omnisim_find_input(const char *name);
omnisim_API int omnisim_find_output(const char *name);
omnisim_API int omnisim_find_parameter(const char *name);
omnisim_API const omnisim_variable *omnisim_input(int input);
omnisim_API const omnisim_variable *omnisim_output(int output);
omnisim_API const omnisim_variable *omnisim_parameter(int parameter);

/* Hold an input at a value from now on, in place of what the scene gives it. */
omnisim_API omnisim_status omnisim_set(omnisim_machine *machine, int input, double value);

/* Give all drives that follow a rate those of this twist of the chassis (m/s, m/s, rad/s, its own axes). */
omnisim_API omnisim_status omnisim_command(omnisim_machine *machine, double vx, double vy, double yaw_rate);

/* An output as it is now; NaN for a number that is none. Forces are found once for each instant somebody asks for them,
   with the inputs that have acted up to now. */
omnisim_API double omnisim_get(omnisim_machine *machine, int output);

/* The whole state as so many bytes, for this library alone; what follows omnisim_restore is what followed omnisim_save,
   bit for bit. REFUSED for bytes that are no such state. A state of a machine that had been STOPPED is one again. */
omnisim_API size_t omnisim_state_size(void);
omnisim_API void omnisim_save(const omnisim_machine *machine, void *state);
omnisim_API omnisim_status omnisim_restore(omnisim_machine *machine, const void *state);

/* How the machine was stopped, or why the last call was refused; "" while all is well. Until the next call. */
omnisim_API const char *omnisim_message(const omnisim_machine *machine);

/* Whether something has stopped it. */
omnisim_API int omnisim_stopped(const omnisim_machine *machine);

#ifdef __cplusplus
}
#endif
#endif
