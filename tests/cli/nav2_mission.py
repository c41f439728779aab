"""A mission of the shape of Nav2's default: plans at 1 Hz, drives, and recovers in turn."""

_TEXT = """<root BTCPP_format="4" main_tree_to_execute="Navigate">
  <BehaviorTree ID="Navigate">
    <RecoveryNode number_of_retries="{retries}" name="navigate">
      <PipelineSequence name="plan and drive">
        <ProgressCheckerSelector default_progress_checker="checker" selected_progress_checker="{{progress}}"/>
        <GoalCheckerSelector default_goal_checker="checker" selected_goal_checker="{{reached}}"/>
        <ControllerSelector default_controller="FollowPath" selected_controller="{{controller}}"/>
        <PlannerSelector default_planner="GridBased" selected_planner="{{planner}}" topic_name="planner_selector"/>
        <RateController hz="1.0">
          <RecoveryNode number_of_retries="1" name="plan">
            <ComputePathToPose goal="{{goal}}" path="{{path}}" planner_id="{{planner}}"
                               error_code_id="{{plan_error}}" error_msg="{{plan_text}}"/>
            <Sequence>
              <WouldAPlannerRecoveryHelp error_code="{{plan_error}}"/>
              <ClearEntireCostmap service_name="global_costmap/clear_entirely_global_costmap"/>
            </Sequence>
          </RecoveryNode>
        </RateController>
        <RecoveryNode number_of_retries="1" name="drive">
          <FollowPath path="{{path}}" controller_id="{{controller}}" goal_checker_id="{{reached}}"
                      progress_checker_id="{{progress}}" error_code_id="{{drive_error}}" error_msg="{{drive_text}}"/>
          <Sequence>
            <WouldAControllerRecoveryHelp error_code="{{drive_error}}"/>
            <ClearEntireCostmap service_name="local_costmap/clear_entirely_local_costmap"/>
          </Sequence>
        </RecoveryNode>
      </PipelineSequence>
      <Sequence name="recover">
        <Fallback name="would a recovery help">
          <WouldAControllerRecoveryHelp error_code="{{drive_error}}"/>
          <WouldAPlannerRecoveryHelp error_code="{{plan_error}}"/>
        </Fallback>
        <ReactiveFallback name="recoveries">
          <GoalUpdated/>
          <RoundRobin name="in turn">
            <Sequence name="clear">
              <ClearEntireCostmap service_name="local_costmap/clear_entirely_local_costmap"/>
              <ClearEntireCostmap service_name="global_costmap/clear_entirely_global_costmap"/>
            </Sequence>
            <Spin spin_dist="{spin}" error_code_id="{{spin_error}}" error_msg="{{spin_text}}"/>
            <Wait wait_duration="{wait}" error_code_id="{{wait_error}}" error_msg="{{wait_text}}"/>
            <BackUp backup_dist="{back_up}" backup_speed="0.15"
                    error_code_id="{{back_error}}" error_msg="{{back_text}}"/>
          </RoundRobin>
        </ReactiveFallback>
      </Sequence>
    </RecoveryNode>
  </BehaviorTree>
</root>
"""


def mission(retries: int = 6, spin: float = 0.8, wait: float = 0.5, back_up: float = 0.1) -> str:
    """XML of the mission.

    Args:
        retries: Recoveries before it fails.
        spin: Angle of a turn [rad].
        wait: Duration of a wait [s].
        back_up: Distance of backing up [m].
    """
    return _TEXT.format(retries=retries, spin=spin, wait=wait, back_up=back_up)
