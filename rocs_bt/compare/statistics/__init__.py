"""Statistics of episodes over scenes and seeds: plain functions of arrays values[scene, seed]."""

from .anytime import always_valid, log_wealth
from .estimate import LEVEL, Estimate, mean, share
from .means import mean_difference, mean_over_scenes, paired
from .power import POWER, mcnemar_power, scenes_needed
from .profile import interquartile_mean, performance_profile
from .rate import lower_bound, rate, upper_bound
from .resampling import bootstrapped, cluster_bootstrap, holm, mcnemar_test, sign_flip_test, superiority
from .scenes import Floats, Size, sample_size, scene_means
from .survival import cumulative_incidence, restricted_mean_time

__all__ = [
    "LEVEL",
    "POWER",
    "Estimate",
    "Floats",
    "Size",
    "always_valid",
    "bootstrapped",
    "cluster_bootstrap",
    "cumulative_incidence",
    "holm",
    "interquartile_mean",
    "log_wealth",
    "lower_bound",
    "mcnemar_power",
    "mcnemar_test",
    "mean",
    "mean_difference",
    "mean_over_scenes",
    "paired",
    "performance_profile",
    "rate",
    "restricted_mean_time",
    "sample_size",
    "scene_means",
    "scenes_needed",
    "share",
    "sign_flip_test",
    "superiority",
    "upper_bound",
]
