/* scene_: one scene in steps of fixed length; see scene_.c. States, parameters and outputs are in this order. */
#ifndef SCENE__H
#define SCENE__H

#ifdef __cplusplus
extern "C" {
#endif

@LAYOUT@
/* State of a run. t, x and memory may be set from outside between steps; then scene__begin is to be called again, unless
   only x changed by a little. A t that was set becomes the new origin. */
typedef struct {
  double t;
  double x[SCENE__ARRAY(SCENE__STATES)];
  double memory[SCENE__ARRAY(SCENE__MEMORY)];
  double origin, steps; /* scene__step counts: t = origin + steps * SCENE__STEP, which a sum of steps would drift from */
} scene__state;

extern const double scene__parameters[SCENE__ARRAY(SCENE__PARAMETERS)]; /* values of the scene */
extern const double scene__initial[SCENE__ARRAY(SCENE__STATES)];        /* start of the scene */

/* Set the start of the scene at t = 0. p: parameters, of length SCENE__PARAMETERS; v: inputs, which may be NULL if there
   are none. */
void scene__reset(scene__state *s, const double *p, const double *v);

/* Find which contacts stick at the state s->x and the time s->t, and which samples of held variables and resets have been;
   those whose instant is s->t happen now. */
void scene__begin(scene__state *s, const double *p, const double *v);

/* Go on by SCENE__STEP with the inputs v at s->t and their slopes dv, NULL for constant ones. Return 0 if all is right,
   1 after more events than a step resolves (the rest of the step is of first order), 2 if a normal load became negative,
   3 if the state is not finite. */
int scene__step(scene__state *s, const double *p, const double *v, const double *dv);

/* The same for a step of length h > 0. */
int scene__advance(scene__state *s, const double *p, const double *v, const double *dv, double h);

/* Compute the outputs, and the mode of every contact: -1 slips backward, 0 sticks, 1 slips forward. */
void scene__look(const scene__state *s, const double *p, const double *v, double *outputs, double *modes);

#ifdef __cplusplus
}
#endif
#endif
