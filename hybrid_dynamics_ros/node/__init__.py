"""The ROS 2 node: wiring of the pipeline and the services to topics, parameters and a lifecycle."""
