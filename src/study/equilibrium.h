/* What the kind `equilibrium` is made of: channels that a state is observed by, one run's series of
 * them, and when a series has settled. */
#ifndef DL_STUDY_EQUILIBRIUM_H
#define DL_STUDY_EQUILIBRIUM_H

#include "driftlab/observe.h"
#include "observe/series.h"
#include "study/kind.h"

/* Whose velocity is none: that of the mass centre changes neither temperature nor shape. */
typedef enum dl_equilibrium_frame {
    DL_EQUILIBRIUM_LAB,
    DL_EQUILIBRIUM_CENTRE
} dl_equilibrium_frame;

typedef struct dl_equilibrium_settings {
    long runs;           /* from starts that differ by `displacement` */
    double displacement; /* of every coordinate, its root mean square */
    double bin;          /* of heights; 0: chosen */
    int frame;           /* dl_equilibrium_frame: of the kinetic energy */
} dl_equilibrium_settings;

enum { DL_MOST_CHANNELS = 40, DL_CHANNEL_NAME = 64 };

/* One number of a state. */
typedef struct dl_channel {
    char name[DL_CHANNEL_NAME]; /* "kinetic energy per particle [energy]" */
    bool tested;                /* has to have settled */
} dl_channel;

/* What of a scene is observed. The first channel is the kinetic energy. */
typedef struct dl_channels {
    size_t count, bins; /* the last bins + 1 are the particles in the bins, and above them */
    dl_channel channel[DL_MOST_CHANNELS];
    dl_bins bin;
    bool heights; /* depths and bins are among them: the scene has weight or a floor */
    double floor;
    bool centre; /* the kinetic energy is that relative to the mass centre */
    size_t moving;
} dl_channels;

/* DL_INPUT where `bin` makes too many bins. */
dl_status dl_channels_create(const dl_scene *scene, const dl_equilibrium_settings *settings,
                             dl_channels *channels, dl_error *error);

/* A run's series. */
typedef struct dl_settling {
    dl_run_summary summary;
    size_t n, room;
    double *time;                    /* [room] */
    double *value[DL_MOST_CHANNELS]; /* [room], in the memory of `time` */
    size_t transient;                /* samples left out */
    double change;                   /* in standard errors, the largest of those tested; NAN:
                                        it cannot be told */
    size_t worst;                    /* its channel */
    bool settled;
    char why[160]; /* it has not; "" where it has */
} dl_settling;

/* Runs and judges; DL_OK whatever becomes of the run, see its summary. Release in any case. */
dl_status dl_settling_run(const dl_study_unit *unit, const dl_channels *channels,
                          const dl_scene *start, const char *label, dl_settling *settling,
                          dl_error *error);
void dl_settling_release(dl_settling *settling);

/* Mean of a channel over what is left after the transient. */
dl_interval dl_settling_mean(const dl_settling *settling, size_t channel);

#endif
